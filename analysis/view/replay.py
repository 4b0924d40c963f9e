"""A run of a log with two ghosts beside it: the nominal and the diagnosed model.

Where the log set's law can be run, they are simulated on the run's reference; where it cannot, they are where each model
expects the machine from its last readings. What separates them is far below what an eye sees at the machine's scale, so ghosts stand
off the measured posture by ``magnify`` times their difference from it.
"""

import html as markup
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..gap.machine import RunData
from ..gap.machines.serial_arm import ArmRun
from ..gap.result import Diagnosis
from ..gap.step_machine import MoveRun
from .logged import pictured
from .skeletons import Floats, Skeleton

FRAMES_PER_SECOND = 30.0
LONGEST = 20.0  # of a replay [s]
SHARE = 0.05  # of the motion, that the larger ghost's difference is magnified to
SWELL = (
    1.0,
    1.35,
    1.15,
)  # of measured, nominal and diagnosed: copies in one place stay apart to the eye
STILL = 0.01  # share of its range below which a coordinate that travels stands still in this run
MOVE = 0.2  # shown for each move of a machine that is logged move by move [s]


@dataclass(frozen=True, kw_only=True)
class Replay:
    """Coordinates of the skeleton over time, (samples, coordinates) each."""

    machine: Skeleton
    run: str
    time: Floats  # (samples,) [s]
    measured: Floats
    ghosts: dict[str, Floats]  # already magnified; those that diverge are left out
    magnify: float
    simulated: bool  # from the run's reference; else predicted from the last readings
    moves: bool = False  # whether a sample is a move


def replay(diagnosis: Diagnosis, run: str | None = None, magnify: float | None = None) -> Replay:
    """The named run, or the first that moves, held-out ones first.

    InputError for another name or a machine without a shape.

    Without ``magnify`` the larger difference becomes 5 % of the motion, in the coordinates that move.
    """
    chosen = _choose(diagnosis, run)
    machine, coordinates = pictured(diagnosis)
    time, position, models, simulated = _paths(diagnosis, chosen)
    measured = coordinates(position)
    ghosts = {name: coordinates(model) for name, model in models.items()}
    if magnify is None:
        magnify = _magnified(machine, measured, ghosts)
    return Replay(
        machine=machine,
        run=chosen.name,
        time=time,
        measured=measured,
        ghosts={name: measured + magnify * (m - measured) for name, m in ghosts.items()},
        magnify=magnify,
        simulated=simulated,
        moves=isinstance(chosen, MoveRun),
    )


def _magnified(machine: Skeleton, measured: Floats, ghosts: dict[str, Floats]) -> float:
    """Factor that makes the largest difference ``SHARE`` of the motion."""
    largest = max(
        (np.max(np.abs(model - measured), axis=0) for model in ghosts.values()),
        key=np.max,
        default=np.zeros(1),
    )
    travel = np.ptp(measured, axis=0)
    moved = travel > STILL * np.array([c.high - c.low for c in machine.coordinates])
    shares = largest[moved] / travel[moved]
    return max(1.0, float(SHARE / np.max(shares))) if shares.size and shares.max() else 1.0


def page(found: Replay) -> str:
    """Self-contained HTML (about 2 MB) with the recording: measured in grey, nominal vermilion, diagnosed blue."""
    from .scene import BLUE, STEEL, VERMILION, Drawing, look, open_meshcat

    meshcat = open_meshcat()
    colours = {"nominal": VERMILION, "diagnosed": BLUE}
    copies = {"measured": (found.measured, STEEL)} | {
        name: (values, colours[name]) for name, values in found.ghosts.items()
    }
    drawings = {
        name: Drawing(meshcat, found.machine, name, colour, swell)
        for (name, (_, colour)), swell in zip(copies.items(), SWELL)
    }
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
        f"{markup.escape(found.machine.name)}, run {markup.escape(found.run)}: {', '.join(entries)}. {_how(found)} They stand "
        f"off the measured posture by {_times(found.magnify)} their difference from it.</div>"
    )
    assert text.count("</body>") == 1
    return text.replace("</body>", f"{caption}</body>")


def _how(found: Replay) -> str:
    """Where the ghosts come from, one sentence."""
    if found.moves:
        return f"Every {MOVE:g} s shows the end of a move, and where each model puts it."
    if found.simulated:
        return "The models are simulated on the run's reference."
    return "Each model says from the last readings where the machine will be."


def _times(magnify: float) -> str:
    """Three digits in full: ``12 300 times``."""
    if magnify == 1.0:
        return "just"
    rounded = float(f"{magnify:.3g}")
    full = f"{rounded:,.0f}" if rounded >= 1000.0 else f"{rounded:g}"
    return f"{full.replace(',', chr(0xA0))} times"


def _choose(diagnosis: Diagnosis, name: str | None) -> RunData:
    runs = {run.name: run for run in diagnosis.runs}
    if name is None:
        held_out = [r for r in diagnosis.runs if r.use == "validate"]
        rest = [r for r in diagnosis.runs if r.use != "validate"]
        most = max(_travel(r) for r in diagnosis.runs)
        return next(r for r in (*held_out, *rest) if _travel(r) >= STILL * most)
    if name not in runs:
        raise InputError("--run", f"unknown run {name!r}", f"one of {', '.join(runs)}")
    return runs[name]


def _travel(run: RunData) -> float:
    """The largest travel of a coordinate in a run, in its unit; without end where every sample is a move."""
    return (
        np.inf
        if isinstance(run, MoveRun)
        else float(np.ptp(run.position[run.window], axis=0).max())
    )


def _paths(diagnosis: Diagnosis, run: RunData) -> tuple[Floats, Floats, dict[str, Floats], bool]:
    """Times, measured positions (samples, n), those of the models, and whether they are simulated."""
    machine = diagnosis.machine
    fits = {"nominal": diagnosis.nominal, "diagnosed": diagnosis.chosen}
    plants = {
        name: fit.hypothesis.plant(machine, fit.by_key(), run.start) for name, fit in fits.items()
    }
    loops = {name: machine.simulate(run, plant) for name, plant in plants.items()}
    if any(loop is not None for loop in loops.values()):
        found = {name: np.asarray(loop[0]) for name, loop in loops.items() if loop is not None}
        return run.t - run.t[0], run.position, _finite(found), True
    errors = {name: machine.predict(run, plant) for name, plant in plants.items()}
    time, position = run.t[run.window] - run.t[run.window][0], run.position[run.window]
    if isinstance(run, MoveRun):
        position, errors = _moves(diagnosis, run, errors)
        time = MOVE * np.arange(len(position))
    found = {name: position - error for name, error in errors.items()}
    return time, position, _finite(found), isinstance(run, ArmRun)


def _moves(
    diagnosis: Diagnosis, run: MoveRun, errors: dict[str, Floats]
) -> tuple[Floats, dict[str, Floats]]:
    """Joints (moves, 3) after every move, and by how much each model misses them."""
    columns = next(r for r in diagnosis.logset.runs if r.name == run.name).columns
    after = np.column_stack([columns[f"q{i}"] for i in (1, 2, 3)])[run.window]
    after[:, run.joint] += run.moved[run.window]
    scale = (run.steps * run.expected)[run.window]
    missed = {name: np.zeros_like(after) for name in errors}
    for name, error in errors.items():
        missed[name][:, run.joint] = error[:, 0] * scale
    return after, missed


def _finite(paths: dict[str, Floats]) -> dict[str, Floats]:
    """Without those that diverge."""
    return {name: path for name, path in paths.items() if np.isfinite(path).all()}
