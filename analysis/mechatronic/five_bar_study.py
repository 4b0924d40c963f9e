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
from ...models.paths import Circle
from ...models.servo_axis import ServoAxis
from ..files import write_folder
from . import five_bar_variants, friction_identification
from .five_bar_variants import CIRCLES, Variant
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
                    printed=five_bar_variants.PRINTED,
                    remark=f"at y = {HEIGHT} m and feed-forward {loop.feedforward}, neither printed",
                )
            )
        else:
            rows.append(
                Row(
                    quantity=f"{name}, joint error [motor turns]",
                    ours=numbers["joint_error_motor_turns"],
                    printed=CIRCLES[name].error,
                    remark=f"the same feed-forward; about {CENTRE} m with {ACCELERATION} m/s^2 along it, as in the X "
                    "move: neither printed",
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


def _circle(name: str) -> list[Row]:
    """The speed reached, what no circle at full feed could have without feed-forward, and what the printed lag of the velocity says."""
    path, printed = MOTIONS[name], CIRCLES[name]
    assert isinstance(path, Circle)
    return [
        Row(
            quantity=f"{name}, largest speed [m/s]",
            ours=path.acceleration * path.profile.ramp,
            printed=path.feed,
            remark="one turn; below the feed it is too short for this acceleration: a fast circle at constant feed has an "
            "error above the printed one (below, two turns)",
        ),
        Row(
            quantity=f"{name}, least error without feed-forward [motor turns]",
            ours=five_bar_variants.least_error(path, GAINS[name]),
            printed=printed.error,
            remark="feed / (l1 k_v), wherever the circle lies: the printed error asks for feed-forward",
        ),
        Row(
            quantity=f"{name}, error of the printed lag of {printed.lag:g} s [motor turns]",
            ours=printed.lag * five_bar_variants.peak_rate(path),
            printed=printed.error,
            remark="largest rate times lag: the printed lag and the printed error exclude each other",
        ),
    ]


def variant_table(variants: list[Variant]) -> Table:
    """For the terminal."""
    out = Table(title="One assumption changed at a time, lag of the position loop alone")
    for heading in ("assumption", "X move [mm]", "circle [turns]", "fast circle [turns]"):
        out.add_column(heading)
    for v in variants:
        out.add_row(v.name, f"{v.off_path:.1f}", f"{v.circle:.3f}", f"{v.fast_circle:.3f}")
    errors = (f"{CIRCLES[name].error:g}" for name in ("circle", "fast-circle"))
    out.add_row("printed", f"{five_bar_variants.PRINTED:g}", *errors)
    return out


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


def write(rows: list[Row], variants: list[Variant], out: Path) -> list[Path]:
    """``comparison.json``."""
    document: dict[str, Any] = {
        "source": "Roldan, section 4.1",
        "rows": [asdict(r) for r in rows],
        "variants": [asdict(v) for v in variants],
    }
    text = json.dumps(document, indent=1, allow_nan=False)
    return write_folder(
        out, {"comparison.json": lambda path: path.write_text(text, encoding="utf-8")}
    )
