"""A run of a log with two ghosts beside it: the nominal and the diagnosed model under the same controller.

What separates them is far below what an eye sees at the machine's scale, so ghosts stand off the measured posture by
``magnify`` times their difference from it.
"""

import html as markup
from dataclasses import dataclass

import numpy as np

from ...models import c_drive
from ..errors import InputError
from ..gap.diagnosis import Diagnosis
from ..gap.machine import RunData
from .skeletons import Floats, Skeleton, skeleton

FRAMES_PER_SECOND = 30.0
LONGEST = 20.0  # of a replay [s]
SHARE = 0.05  # of the motion, that the larger ghost's difference is magnified to
STILL = 0.01  # share of its range below which a coordinate that travels stands still in this run


@dataclass(frozen=True, kw_only=True)
class Replay:
    """Coordinates of the skeleton over time, (samples, coordinates) each."""

    machine: Skeleton
    run: str
    time: Floats  # (samples,) [s]
    measured: Floats
    ghosts: dict[str, Floats]  # already magnified; those that diverge are left out
    magnify: float


def replay(diagnosis: Diagnosis, run: str | None = None, magnify: float | None = None) -> Replay:
    """The named run, or the first held-out one; InputError for another name or a machine without a picture.

    Without ``magnify`` the larger difference becomes 5 % of the motion, in the coordinates that move.
    """
    chosen = _choose(diagnosis, run)
    machine = skeleton(_name(diagnosis))
    measured = _coordinates(diagnosis, chosen.position)
    models = {
        name: _coordinates(diagnosis, position)
        for name, fit in (("nominal", diagnosis.nominal), ("diagnosed", diagnosis.chosen))
        if (position := _simulated(diagnosis, chosen, fit)) is not None
    }
    if magnify is None:
        largest = max(
            (np.max(np.abs(model - measured), axis=0) for model in models.values()),
            key=np.max,
            default=np.zeros(1),
        )
        travel = np.ptp(measured, axis=0)
        moved = travel > STILL * np.array([c.high - c.low for c in machine.coordinates])
        shares = largest[moved] / travel[moved]
        magnify = max(1.0, float(SHARE / np.max(shares))) if shares.size and shares.max() else 1.0
    return Replay(
        machine=machine,
        run=chosen.name,
        time=chosen.t - chosen.t[0],
        measured=measured,
        ghosts={name: measured + magnify * (m - measured) for name, m in models.items()},
        magnify=magnify,
    )


def page(found: Replay) -> str:
    """Self-contained HTML (about 2 MB) with the recording: measured in grey, nominal vermilion, diagnosed blue."""
    from .scene import BLUE, STEEL, VERMILION, Drawing, look, open_meshcat

    meshcat = open_meshcat()
    colours = {"nominal": VERMILION, "diagnosed": BLUE}
    copies = {"measured": (found.measured, STEEL)} | {
        name: (values, colours[name]) for name, values in found.ghosts.items()
    }
    drawings = {n: Drawing(meshcat, found.machine, n, colour) for n, (_, colour) in copies.items()}
    look(meshcat, found.machine)
    dt = float(found.time[1] - found.time[0])
    every = max(1, round(1.0 / (FRAMES_PER_SECOND * dt)))
    last = min(len(found.time), round(LONGEST / dt))
    meshcat.StartRecording(frames_per_second=FRAMES_PER_SECOND)
    for k in range(0, last, every):
        for name, (values, _) in copies.items():
            drawings[name].move(values[k], float(found.time[k]))
    meshcat.StopRecording()
    meshcat.PublishRecording()
    return _with_legend(str(meshcat.StaticHtml()), found)


def _with_legend(text: str, found: Replay) -> str:
    """A caption over the picture: who is who, and how much the differences are enlarged."""
    who = {"nominal": "#d55e00", "diagnosed": "#0072b2"}
    entries = ["<b style='color:#595e66'>measured</b>"] + [
        f"<b style='color:{who[name]}'>{name} model</b>" for name in found.ghosts
    ]
    caption = (
        "<div role='note' style='position:fixed;left:1rem;bottom:1rem;max-width:28rem;padding:.6rem .8rem;"
        "background:#fffffff0;color:#1a1a1a;font:15px/1.4 system-ui,sans-serif;border-radius:.4rem'>"
        f"{found.machine.name}, run {markup.escape(found.run)}: {', '.join(entries)}. The models stand off the measured "
        f"posture by {_times(found.magnify)} their difference from it.</div>"
    )
    assert text.count("</body>") == 1
    return text.replace("</body>", f"{caption}</body>")


def _times(magnify: float) -> str:
    return f"{magnify:.3g} times" if magnify != 1.0 else "just"


def _choose(diagnosis: Diagnosis, name: str | None) -> RunData:
    runs = {run.name: run for run in diagnosis.runs}
    if name is None:
        return next((r for r in diagnosis.runs if r.use == "validate"), diagnosis.runs[0])
    if name not in runs:
        raise InputError("--run", f"unknown run {name!r}", f"one of {', '.join(runs)}")
    return runs[name]


def _name(diagnosis: Diagnosis) -> str:
    return diagnosis.machine.kind.replace("_", "-")


def _simulated(diagnosis: Diagnosis, run: RunData, fit: object) -> Floats | None:
    """Position (samples, n) of the closed loop with a fitted model, None where it diverges."""
    machine = diagnosis.machine
    plant = fit.hypothesis.plant(machine, fit.by_key(), run.start)  # type: ignore[attr-defined]
    loop = machine.simulate(run, plant)
    if loop is None or not np.isfinite(loop[0]).all():
        return None
    return np.asarray(loop[0])


def _coordinates(diagnosis: Diagnosis, position: Floats) -> Floats:
    """Coordinates of the skeleton from the encoders' positions (samples, n)."""
    kind = diagnosis.machine.kind
    if kind == "c_drive":
        lead = float(diagnosis.logset.system["nominal"].get("lead_m_per_rev", 0.060))
        return c_drive.collar_pose(position, lead)
    if kind == "slider":
        return position
    if kind == "pmc":
        from ...models.pmc import constants

        system = diagnosis.logset.system
        lead = float(system["nominal"]["drive"]["lead"])
        return np.asarray(system["home"]) + position @ constants.joint_map(lead).T
    raise InputError("view", f"no picture of a {kind}", "c_drive, slider or pmc")
