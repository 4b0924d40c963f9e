"""Controllers of the C-drive beside the printed results: Friedlaender 2015, Tables 5-4 to 5-9.

``ours`` is the block-diagram simulation by the setting that reproduces the printed one
(``models.benchmark.thesis_controllers``); ``ours_sampled`` is the same test with sampled controllers, as
on a machine. Comparison of data only; pictures and pages are made in ``comparison_page.py``.
"""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import Any

from ..models import benchmark, c_drive, thesis_tables
from ..models.benchmark import SETTINGS, Conditions
from ..models.c_drive import CDriveParameters
from ..models.thesis_tables import Key, PrintedRow

SOURCE = "Friedlaender 2015, Tables 5-4, 5-7, 5-8 and 5-9"
MODEL_FACTOR = 0.95  # M and D in the controller's model of the block diagram
SAMPLED_MODEL_FACTOR = 1.05


@dataclass(frozen=True, kw_only=True)
class ComparedRow:
    """One printed number and ours; None where the thesis prints none."""

    controller: str
    motion: str
    rate_Hz: float
    metric: str
    ours: float
    ours_sampled: float
    thesis_sim: float | None
    thesis_exp: float | None
    relative_error: float | None  # ours / thesis_sim - 1; None where the print is absent or zero
    within_print: bool | None  # ours rounds to the printed simulation, four decimals


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """All rows and where they come from."""

    rows: tuple[ComparedRow, ...]
    provenance: dict[str, Any]

    def select(self, *, metrics: Iterable[str], rate_Hz: float) -> list[ComparedRow]:
        """Rows of these metrics at this rate, in the order of the tables."""
        wanted = set(metrics)
        return [row for row in self.rows if row.metric in wanted and row.rate_Hz == rate_Hz]

    def as_json(self) -> dict[str, Any]:
        """The document ``comparison.json``."""
        return {"provenance": self.provenance, "rows": [asdict(row) for row in self.rows]}


def compare_c_drive(parameters: CDriveParameters | None = None) -> Comparison:
    """Simulate the benchmark at 2 Hz and 1 Hz and set it beside the tables."""
    parameters = parameters or CDriveParameters()
    plant = c_drive.drive(parameters)
    blocks = benchmark.thesis_controllers(parameters, model_factor=MODEL_FACTOR)
    sampled = benchmark.sampled_controllers(parameters, model_factor=SAMPLED_MODEL_FACTOR)
    rows: list[ComparedRow] = []
    for rate in (2.0, 1.0):
        conditions = Conditions(rate=rate)
        ours = benchmark.benchmark_metrics(plant, blocks, conditions)
        held = benchmark.benchmark_metrics(plant, sampled, conditions)
        printed = [row for row in thesis_tables.all_rows() if row.rate_Hz == rate]
        rows += [_compare(row, ours, held) for row in printed]
    return Comparison(rows=tuple(rows), provenance=_provenance(parameters))


def _compare(row: PrintedRow, ours: dict[Key, float], sampled: dict[Key, float]) -> ComparedRow:
    value = ours[row.key]
    return ComparedRow(
        **asdict(row),
        ours=value,
        ours_sampled=sampled[row.key],
        relative_error=value / row.thesis_sim - 1.0 if row.thesis_sim else None,
        within_print=None
        if row.thesis_sim is None
        else abs(value - row.thesis_sim) <= thesis_tables.HALF_PRINT,
    )


def _provenance(parameters: CDriveParameters) -> dict[str, Any]:
    conditions = Conditions()
    return {
        "program": f"gapscope {version('gapscope')}",
        "source": SOURCE,
        "parameters": asdict(parameters),
        "controllers": {name: _settings(settings) for name, settings in SETTINGS.items()},
        "conditions": {
            "step_s": conditions.dt,
            "cycles_simulated": conditions.cycles,
            "cycles_left_out": 1,
            "encoder_bits": 13,
        },
        "ours": {
            "loop": "continuous blocks under ODE4, unit delay of the torque to the observer",
            "model_factor": MODEL_FACTOR,
            "dead_zone_counts": 1.0,
        },
        "ours_sampled": {
            "loop": "sampled controller, torque held",
            "model_factor": SAMPLED_MODEL_FACTOR,
            "dead_zone_counts": 0.0,
        },
    }


def _settings(settings: Any) -> dict[str, Any]:
    """Gains for JSON, complex poles as [real, imaginary]."""
    return {
        key: [[complex(pole).real, complex(pole).imag] for pole in value]
        if key == "poles"
        else value
        for key, value in asdict(settings).items()
    }
