"""Where the gap lies: shares of its energy, by joint, task coordinate, regime, band and run."""

from collections.abc import Sequence
from typing import Any

from .base import Material, Section

LISTS = (
    ("joints", "by joint"),
    ("task", "by task coordinate"),
    ("signals", "by signal"),
    ("regimes", "by regime of the motion"),
    ("directions", "by direction"),
    ("speeds", "by share of the top speed"),
    ("accelerations", "by share of the top acceleration"),
    ("since_reversal", "by time since the last reversal"),
    ("positions", "by position"),
    ("loads", "by share of the largest command"),
    ("bands", "by frequency"),
    ("harmonics", "by what repeats with the cycle"),
    ("times", "by time"),
    ("runs", "by run"),
)
MAPS = (
    ("joint_regimes", "joint", "regime", "joint by regime"),
    ("joint_bands", "joint", "band", "joint by frequency"),
)


def context(material: Material) -> dict[str, Any]:
    """Bars for every list of shares, heat maps for those by joint and something else."""
    location = material.diagnosis.location
    return {
        "no_gap": material.diagnosis.verdict.verdict == "no_gap",
        "lists": [
            (title, _bars(location[key])) for key, title in LISTS if len(location.get(key, [])) > 1
        ],
        "maps": [
            {"title": title, **_heat_map(location[key], row, column)}
            for key, row, column, title in MAPS
            if location.get(key) and len(material.diagnosis.machine.joints) > 1
        ],
    }


def _bars(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{"name": r["name"], "share": r["share"], "ci95": r.get("ci95")} for r in rows]


def _heat_map(cells: Sequence[dict[str, Any]], row: str, column: str) -> dict[str, Any]:
    names = list(dict.fromkeys(cell[row] for cell in cells))
    columns = list(dict.fromkeys(cell[column] for cell in cells))
    shares = {(cell[row], cell[column]): cell["share"] for cell in cells}
    top = max(shares.values()) or 1.0
    return {
        "columns": columns,
        "rows": [
            (name, [(shares[name, c], round(shares[name, c] / top, 3)) for c in columns])
            for name in names
        ],
    }


SECTION = Section(key="where", title="Where it lies", context=context)
