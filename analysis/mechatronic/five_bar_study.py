"""``gapscope compare 5r``: section 4.1 of Roldan, our numbers beside the printed ones."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NamedTuple

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
from ...models.paths import Circle, Line
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


class Circled(NamedTuple):
    """What is printed of the model on a circle, read from Figs. 4.9 and 4.10."""

    error: float  # of a joint [motor turns]
    lag: float  # of the velocity [s]


CIRCLES = {"circle": Circled(0.25, 0.1), "fast-circle": Circled(0.3, 0.25)}


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
                    printed=CIRCLES[name].error,
                    remark=f"centre {CENTRE} m and {ACCELERATION} m/s^2 along the circle not printed",
                )
            )
            rows += _circle(name)
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


def _circle(name: str) -> list[Row]:
    """What would give a circle's printed error, and what the printed lag of the velocity says of it."""
    path, gain, printed = MOTIONS[name], GAINS[name], CIRCLES[name]
    assert isinstance(path, Circle)
    share = x_move.circle_feedforward(path, gain, printed.error)
    return [
        Row(
            quantity=f"{name}, feed-forward that gives the printed error [-]",
            ours=share,
            printed=None,
            remark="lag of the position loop alone; the X move asks for its own share above",
        ),
        Row(
            quantity=f"{name}, error of the printed lag of {printed.lag:g} s [motor turns]",
            ours=printed.lag * x_move.peak_rate(path),
            printed=printed.error,
            remark="largest rate times lag: the printed lag and the printed error exclude each other",
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
