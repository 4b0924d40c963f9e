r"""When does the machine as a disturbance of its axes (Roldan, Fig. 3.4) differ from one coupled plant?

The load of the disturbance comes from the accelerations of the step before: :math:`a_{k+1} = (\tau - I a_k)/J` in the
joints, an iteration with the factor :math:`-\lambda`, :math:`\lambda = \max \mathrm{eig}(I)/J`, in the machine's inertia I and that
of an axis at its joint, :math:`J = J_t/i_R^2`. So the two agree to first order in the step below :math:`\lambda = 1`, and no
step saves the disturbance above. Each machine keeps its motor and changes its gear, which sets J.
"""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from ...diagrams.servo_loop import Coupling, ServoLoop
from ...models.paths import Path as ToolPath
from ..errors import InputError
from ..files import write_folder
from .servo_machines import MACHINES, motion
from .servo_run import simulate

RATIOS = (0.1, 0.5, 0.9, 1.1, 3.0)  # lambda
SECONDS = 0.1  # of each run


@dataclass(frozen=True, kw_only=True)
class Row:
    """One machine with one gear."""

    machine: str
    ratio: float  # lambda, at the start of the motion [-]
    own: bool  # whether with the gear of the source
    per_motor: float  # joint motion per motor angle [rad or m per rad]
    step: float  # of integration and load [s]
    apart: (
        float | None
    )  # largest difference of a joint, in shares of the largest travel; none: diverged
    apart_half_step: float | None  # the same at half the step
    plant_error: float  # largest error of a joint of the coupled plant, in the same shares


def sweep(progress: Callable[[float], None] = lambda share: None) -> list[Row]:
    """Every machine at its own gear and at those that give ``RATIOS``."""
    rows = []
    for i, (name, machine) in enumerate(MACHINES.items()):
        loop, (chosen, path) = machine.loop(), motion(machine, None)
        if chosen in machine.gains:
            loop = replace(loop, position_gain=machine.gains[chosen])
        own = inertia_ratio(loop, path)
        for k, ratio in enumerate((own, *RATIOS)):
            rows.append(compare(name, geared(loop, path, ratio), path, ratio, own=ratio == own))
            progress((i + (k + 1.0) / (1.0 + len(RATIOS))) / len(MACHINES))
    return rows


def inertia_ratio(loop: ServoLoop, path: ToolPath) -> float:
    """Lambda at the start of a path."""
    q = loop.machine.inverse(path.sample(0.0)[0])
    inertia = loop.machine.equations(q, np.zeros_like(q)).inertia
    return float(np.linalg.eigvalsh(inertia)[-1]) / loop.axis.joint_inertia


def geared(loop: ServoLoop, path: ToolPath, ratio: float) -> ServoLoop:
    """The loop with the gear that gives a ratio lambda; the speed loop is tuned to the inertia a motor then turns."""
    own = inertia_ratio(loop, path)
    heavier = (1.0 + ratio) / (1.0 + own)
    return replace(
        loop,
        axis=replace(loop.axis, per_motor=float(loop.axis.per_motor * np.sqrt(ratio / own))),
        velocity_kp=heavier * loop.velocity_kp,
        velocity_ki=heavier * loop.velocity_ki,
    )


def compare(
    name: str, loop: ServoLoop, path: ToolPath, ratio: float, *, own: bool, seconds: float = SECONDS
) -> Row:
    """Run both couplings, at the loop's step and at half of it; InputError where the plant does not hold."""
    apart: list[float | None] = []
    error = 0.0
    for step in (loop.step, 0.5 * loop.step):
        fine = replace(loop, step=step)
        plant = simulate(replace(fine, coupling=Coupling.plant), path, name, seconds=seconds)
        travel = float(np.ptp(plant.joint_reference, axis=0).max())
        error = float(np.abs(plant.joint_reference - plant.joint_position).max()) / travel
        try:
            late = simulate(
                replace(fine, coupling=Coupling.disturbance), path, name, seconds=seconds
            )
        except InputError:  # it diverged
            apart.append(None)
        else:
            off = np.abs(late.joint_position - plant.joint_position).max()
            apart.append(float(off) / travel)
    return Row(
        machine=name,
        ratio=ratio,
        own=own,
        per_motor=loop.axis.per_motor,
        step=loop.step,
        apart=apart[0],
        apart_half_step=apart[1],
        plant_error=error,
    )


def table(rows: list[Row]) -> Table:
    """For the terminal."""
    out = Table(title="Machine as a disturbance (Fig. 3.4) against one plant")
    for heading in ("machine", "inertia ratio", "apart", "at half the step", "plant's own error"):
        out.add_column(heading)
    for r in rows:
        out.add_row(
            r.machine,
            f"{r.ratio:.3g}" + (" (own gear)" if r.own else ""),
            *(_share(x) for x in (r.apart, r.apart_half_step, r.plant_error)),
        )
    return out


def write(rows: list[Row], out: Path) -> list[Path]:
    """``couplings.json`` and ``couplings.png``."""
    document: dict[str, Any] = {
        "question": "largest difference of a joint between the machine as a disturbance and as one plant, in travels",
        "seconds": SECONDS,
        "rows": [asdict(r) for r in rows],
    }
    text = json.dumps(document, indent=1, allow_nan=False)
    return write_folder(
        out,
        {
            "couplings.json": lambda path: path.write_text(text, encoding="utf-8"),
            "couplings.png": lambda path: plot(rows, path),
        },
    )


def plot(rows: list[Row], path: Path) -> None:
    """Difference over the inertia ratio; what diverged stands on the upper edge."""
    from ..figures import BLUE, GREEN, ORANGE, SKY, VERMILION, plt, style

    with style():
        figure, axes = plt.subplots(figsize=(8.0, 5.0))
        top = 10.0
        for (name, machine), colour, mark in zip(
            MACHINES.items(), (BLUE, ORANGE, GREEN, VERMILION, SKY), "osD^v"
        ):
            mine = sorted((r for r in rows if r.machine == name), key=lambda r: r.ratio)
            both = [(r.ratio, r.apart) for r in mine if r.apart is not None]
            gone = [r.ratio for r in mine if r.apart is None]
            axes.loglog(*zip(*both), "-" + mark, color=colour, label=machine.title, markersize=5)
            axes.plot(gone, [top] * len(gone), mark, color=colour, markersize=5)
            for r in mine:
                if r.own:
                    at = top if r.apart is None else r.apart
                    axes.plot(r.ratio, at, "o", markersize=12, color=colour, fillstyle="none")
        axes.axvline(1.0, color="0.4", linewidth=1.0)
        axes.annotate("diverged", (1.15, top), xytext=(0, 8), textcoords="offset points")
        axes.set_ylim(top=3.0 * top)
        axes.set_xlabel("inertia of the machine per inertia of an axis, at the joint [-]")
        axes.set_ylabel("largest difference of a joint, per travel [-]")
        axes.set_title("Disturbance of Fig. 3.4 against one plant (circled: gear of the source)")
        axes.legend(loc="lower right")
        figure.savefig(path, dpi=130)
        plt.close(figure)


def _share(value: float | None) -> str:
    return "diverged" if value is None else f"{value:.2g}"
