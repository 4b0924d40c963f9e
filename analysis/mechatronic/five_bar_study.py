"""``gapscope compare 5r``: section 4.1 of Roldan, our numbers beside the printed ones."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from ...diagrams.five_bar_loop import (
    ACCELERATION,
    CENTRE,
    GAINS,
    HEIGHT,
    MOTIONS,
    Coupling,
    FiveBarLoop,
)
from ...models.paths import Line
from ...models.servo_axis import ServoAxis
from ..files import write_folder
from . import friction_identification, x_move
from .servo_run import simulate


@dataclass(frozen=True, kw_only=True)
class Row:
    """One number."""

    quantity: str
    ours: float
    printed: float | None
    remark: str = ""


def study(seed: int = 0) -> list[Row]:
    """Table 4.1, the X move, both circles, and what the decoupled scheme costs."""
    identified = friction_identification.identify(
        friction_identification.measure(ServoAxis(), seed=seed)
    )
    rows = [
        Row(
            quantity=f"identified {name}",
            ours=identified.values[name],
            printed=printed,
            remark=f"+- {1.96 * identified.deviations[name]:.2g}, planted as printed, seed {seed}",
        )
        for name, printed in friction_identification.PRINTED.items()
    ]
    for name in ("x-move", "circle", "fast-circle"):
        loop = FiveBarLoop(position_gain=GAINS[name])
        run = simulate(loop, MOTIONS[name], name)
        numbers = run.numbers()
        if name == "x-move":
            rows.append(
                Row(
                    quantity="X move, off the path [mm]",
                    ours=numbers["path_deviation_mm"],
                    printed=22.0,
                    remark=f"at y = {HEIGHT} m, not printed, without feed-forward",
                )
            )
            rows += _unprinted()
        else:
            rows.append(
                Row(
                    quantity=f"{name}, joint error [motor turns]",
                    ours=numbers["joint_error_motor_turns"],
                    printed=0.25 if name == "circle" else 0.3,
                    remark=f"centre {CENTRE} m and {ACCELERATION} m/s^2 along the circle not printed",
                )
            )
        as_plant = FiveBarLoop(position_gain=GAINS[name], coupling=Coupling.plant)
        coupled = simulate(as_plant, MOTIONS[name], name)
        apart = 1e3 * np.linalg.norm(run.position - coupled.position, axis=1).max()
        rows.append(
            Row(
                quantity=f"{name}, disturbance against one plant [mm]",
                ours=float(apart),
                printed=None,
                remark="the load of Fig. 3.4 is one step of 125 us late",
            )
        )
    return rows


def _unprinted() -> list[Row]:
    """What height and feed-forward do to the X move, by the lag of the position loop alone."""
    path, gain = MOTIONS["x-move"], GAINS["x-move"]
    assert isinstance(path, Line)
    rows = [
        Row(
            quantity=f"X move at y = {height:.2f} m, off the path [mm]",
            ours=off,
            printed=x_move.PRINTED,
            remark="lag of the position loop alone, without feed-forward",
        )
        for height, off in x_move.by_height(path, gain).items()
    ]
    share = x_move.feedforward_as_printed(path, gain)
    return [
        *rows,
        Row(
            quantity="feed-forward that gives the printed X move [-]",
            ours=share,
            printed=None,
            remark=f"at y = {HEIGHT} m; no height in reach gives 22 mm without it",
        ),
    ]


def table(rows: list[Row]) -> Table:
    """For the terminal."""
    out = Table(title="Five-bar, Roldan section 4.1")
    for heading in ("quantity", "ours", "printed", "remark"):
        out.add_column(heading)
    for r in rows:
        out.add_row(
            r.quantity, f"{r.ours:.4g}", "" if r.printed is None else f"{r.printed:g}", r.remark
        )
    return out


def write(rows: list[Row], out: Path) -> list[Path]:
    """``comparison.json``."""
    document: dict[str, Any] = {"source": "Roldan, section 4.1", "rows": [asdict(r) for r in rows]}
    text = json.dumps(document, indent=1, allow_nan=False)
    return write_folder(
        out, {"comparison.json": lambda path: path.write_text(text, encoding="utf-8")}
    )
