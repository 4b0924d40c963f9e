"""What a benchmark leaves behind: ``bench.json``, ``bench.png`` and tables in the terminal."""

import json
import os
import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from rich.table import Table

from ..figures import BLUE, VERMILION
from ..files import write_folder
from .rounds import Group, Row


def machine() -> dict[str, Any]:
    """The machine and what it was busy with, as far as the times depend on it."""
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "versions": {name: version(name) for name in ("gapscope", "drake", "numpy", "numba")},
        "load": list(os.getloadavg()) if hasattr(os, "getloadavg") else None,
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


def write(
    groups: Sequence[Group], before: dict[str, Any], after: dict[str, Any], out: Path
) -> list[Path]:
    """Write ``bench.json`` and ``bench.png`` into ``out``, both or neither.

    ``before`` and ``after`` are ``machine()`` at the start and the end of the run.
    """
    document = {
        "machine": before,
        "load_at_the_end": after["load"],
        "ended": after["date"],
        "groups": [group.to_json() for group in groups],
    }
    text = json.dumps(document, indent=2) + "\n"
    return write_folder(
        out,
        {
            "bench.json": lambda path: path.write_text(text, encoding="utf-8"),
            "bench.png": lambda path: plot(groups, path),
        },
    )


def plot(groups: Sequence[Group], path: Path) -> None:
    """Medians with quantiles of the times on a logarithmic axis, one panel a group."""
    heights = [max(1, len(group.rows)) for group in groups]
    figure = Figure(figsize=(8.0, 1.2 * len(groups) + 0.35 * sum(heights)), layout="constrained")
    panels = figure.subplots(len(groups), 1, squeeze=False, height_ratios=heights)[:, 0]
    for axes, group in zip(panels, groups):
        axes.set_title(f"{group.name}, rounds: {group.rounds}", loc="left", fontsize=10)
        if not group.rows:
            axes.set_axis_off()
            axes.text(0.0, 0.5, "; ".join(f"{s.name}: {s.reason}" for s in group.skipped))
            continue
        for place, row in enumerate(reversed(group.rows)):
            spread = [[row.median_s - row.low_s], [row.high_s - row.median_s]]
            colour = BLUE if row.agrees else VERMILION
            axes.errorbar(row.median_s, place, xerr=spread, fmt="o", color=colour, capsize=3)
        axes.set_yticks(range(len(group.rows)), [row.name for row in reversed(group.rows)])
        axes.set_ylim(-0.6, len(group.rows) - 0.4)
        axes.set_xscale("log")
        axes.grid(axis="x", which="both", alpha=0.2)
    panels[-1].set_xlabel(
        "time of one run [s]: median, quantiles 0.1 and 0.9; red: results disagree"
    )
    figure.savefig(path, dpi=150)


def table(group: Group) -> Table:
    """Times, ratios and the check of one group, side by side."""
    shown = Table(
        title=f"{group.name}: {group.task}",
        caption=f"rounds: {group.rounds}; agreement: {group.agreement}",
        title_justify="left",
        caption_justify="left",
    )
    ratio = f"ratio to {group.reference}" if group.reference else ""
    for heading in ("contender", "median", "0.1 - 0.9", ratio, "check"):
        shown.add_column(heading)
    for row in group.rows:
        shown.add_row(
            row.name,
            duration(row.median_s),
            f"{duration(row.low_s)} - {duration(row.high_s)}",
            _ratio(row),
            row.check if row.agrees else f"DISAGREES: {row.check}",
        )
    for one in group.skipped:
        shown.add_row(one.name, "skipped", "", "", one.reason)
    return shown


def _ratio(row: Row) -> str:
    if row.ratio is None:
        return ""
    return f"{row.ratio:.3g} ({row.ratio_low:.3g} - {row.ratio_high:.3g})"


def duration(seconds: float) -> str:
    """A time with three digits and the unit that suits it."""
    for unit, factor in (("s", 1.0), ("ms", 1e3)):
        if seconds * factor >= 1.0:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds * 1e6:.3g} µs"
