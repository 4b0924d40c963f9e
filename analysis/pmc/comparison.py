"""``gapscope compare pmc``: controllers on the test cycles, with and without the counterweight.

Nothing but the gains of the task-space PD is printed about the PMC's performance: the thesis saw position
errors "too small to be visible", a rotation that "does not always" reach its amplitude, and motors too weak without
the counterweight. The rows say what the model makes of that, on the last of three cycles. A PD sags under the weight;
the prototype was calibrated in its sagging posture, which hides the constant part. The stops of screws and limbs are not
modelled: a robot that the motors cannot hold goes on falling beyond them.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...diagrams.pmc_loop import PMCLoopConfig
from ...models.pmc import simulation
from ...models.pmc.controllers import CONTROLLERS
from ...models.pmc.simulation import Run
from ..files import output_folder, write_whole
from . import prototype, statics

Floats = NDArray[np.float64]
CYCLES = 3
# Share by which the controllers' model is too heavy, as in section 5.1.2.
MODEL_ERROR = 0.05
UNITS = {
    "position_rms_mm": "mm",
    "height_rms_mm": "mm",
    "rotation_rms_rad": "rad",
    "rotation_amplitude_error_rad": "rad",
    "tau_rms_Nm": "N m",
    "tau_max_Nm": "N m",
    "saturated_share": "-",
}


@dataclass(frozen=True, kw_only=True)
class Row:
    """One number; ``value`` is None where the robot left its working branch."""

    controller: str
    cycle: str
    counterweight: bool
    metric: str
    value: float | None


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Findings of the comparison."""

    rows: list[Row]
    holding: statics.Holding
    flaws: prototype.PrototypeStudy
    runs: dict[tuple[str, str, bool], Run]

    def value(self, controller: str, cycle: str, counterweight: bool, metric: str) -> float | None:
        """The number of one row; KeyError if there is none."""
        for row in self.rows:
            if (row.controller, row.cycle, row.counterweight, row.metric) == (
                controller,
                cycle,
                counterweight,
                metric,
            ):
                return row.value
        raise KeyError((controller, cycle, counterweight, metric))


def compare() -> Comparison:
    """Run every controller on both cycles, with and without counterweight."""
    runs = dict(_runs())
    rows = [
        Row(controller=name, cycle=cycle, counterweight=weight, metric=metric, value=value)
        for (name, cycle, weight), run in runs.items()
        for metric, value in metrics(run).items()
    ]
    config = PMCLoopConfig()
    machine = config.machine()
    return Comparison(
        rows=rows,
        holding=statics.holding(machine),
        flaws=prototype.study(machine, config.motion(machine).placement),
        runs=runs,
    )


def metrics(run: Run) -> dict[str, float | None]:
    """Metrics over the last cycle of a run; None for each if the robot left its branch."""
    if run.diverged:
        return dict.fromkeys(UNITS)
    last = slice(-(len(run.reference.time) // CYCLES), None)
    errors = (run.poses - run.reference.poses)[last]
    rotation, wanted = run.poses[last, 3], run.reference.poses[last, 3]
    command = np.abs(run.command[last])
    values = {
        "position_rms_mm": 1e3 * np.sqrt((errors[:, :2] ** 2).sum(axis=1).mean()),
        "height_rms_mm": 1e3 * _rms(errors[:, 2]),
        "rotation_rms_rad": _rms(errors[:, 3]),
        "rotation_amplitude_error_rad": np.ptp(rotation) - np.ptp(wanted),
        "tau_rms_Nm": _rms(command),
        "tau_max_Nm": command.max(),
        "saturated_share": np.mean(command >= run.parameters.torque_limit * (1.0 - 1e-12)),
    }
    return {name: float(value) for name, value in values.items()}


def write(result: Comparison, out: Path) -> None:
    """Write ``comparison.json``, ``comparison.md``, ``comparison.png`` and ``prototype.png``."""
    from . import comparison_plot, prototype_plot

    folder = output_folder(out)
    write_whole(folder / "comparison.json", dumps(result))
    write_whole(folder / "comparison.md", markdown(result))
    write_whole(folder / "comparison.png", comparison_plot.png(result))
    write_whole(folder / "prototype.png", prototype_plot.png(result.flaws))


def dumps(result: Comparison) -> str:
    """``comparison.json`` as text."""
    content = {
        "units": UNITS,
        "model_error": MODEL_ERROR,
        "rows": [asdict(row) for row in result.rows],
        "counterweight": asdict(result.holding),
        "finding": finding(result),
        "prototype": prototype.findings(result.flaws),
    }
    return json.dumps(content, indent=1, allow_nan=False) + "\n"


def finding(result: Comparison) -> str:
    """The thesis's observation about the counterweight, with the model's numbers."""
    h = result.holding
    limit = str(PMCLoopConfig().machine().torque_limit)
    return (
        f"At the isotropic posture the motors need {h.isotropic['without']:.2f} N m each without the "
        f"counterweight and {h.isotropic['with']:.2f} N m with it; they have {limit} N m. Without it they "
        f"hold the robot in {100 * h.held_share['without'][limit]:.0f} % of the workspace, with it in "
        f"{100 * h.held_share['with'][limit]:.0f} %. Of {h.samples} mass splits within "
        f"{100 * h.spread:.0f} % of the assumed values (seed {h.seed}), "
        f"{100 * h.needs_counterweight:.0f} % need it to be held and are held with it."
    )


def markdown(result: Comparison) -> str:
    """One table per cycle, with and without counterweight."""
    lines = ["# Controllers of the PepperMill-Carrier", "", finding(result), ""]
    for cycle in ("industry", "smooth"):
        for weight in (True, False):
            lines += [f"## {cycle} cycle, {'with' if weight else 'without'} counterweight", ""]
            lines += ["| controller | " + " | ".join(UNITS) + " |", "|---" * (len(UNITS) + 1) + "|"]
            for name in CONTROLLERS:
                values = [result.value(name, cycle, weight, metric) for metric in UNITS]
                cells = ["left its branch" if v is None else f"{v:.4g}" for v in values]
                lines.append(f"| {name} | " + " | ".join(cells) + " |")
            lines.append("")
    return "\n".join(lines)


def _runs() -> Iterator[tuple[tuple[str, str, bool], Run]]:
    for cycle in ("industry", "smooth"):
        config = PMCLoopConfig(cycle=cycle)
        machine = config.machine()
        reference = simulation.sample_cycle(config.motion(machine), machine, cycles=CYCLES)
        for weight in (True, False):
            robot = machine if weight else statics.without_counterweight(machine)
            for name, settings in CONTROLLERS.items():
                believed = robot.heavier(MODEL_ERROR)
                yield (
                    (name, cycle, weight),
                    simulation.run(reference, settings, robot, believed=believed),
                )


def _rms(values: Any) -> Any:
    return np.sqrt(np.mean(np.square(values)))
