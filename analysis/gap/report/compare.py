"""Several diagnoses side by side on one self-contained page, from their ``diagnosis.json`` alone."""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2

from ...errors import InputError
from ...files import output_folder, write_whole
from ..effects import catalogue
from .words import confidence, interval, listed, number, percent

FILE = "comparison.html"
VERDICTS = {
    "explained": "explained",
    "no_gap": "no gap",
    "ambiguous": "ambiguous",
    "unexplained": "unexplained",
}
NEEDED = ("verdict", "effects", "location", "shrinkage", "warnings", "provenance")


@dataclass(frozen=True)
class Named:
    """A diagnosis by a name that no other of the comparison has."""

    name: str
    content: Mapping[str, Any]


def load(paths: Sequence[Path]) -> list[Named]:
    """Diagnoses from their folders or ``diagnosis.json``; InputError for fewer than two or a bad file."""
    if len(paths) < 2:
        raise InputError("compare diagnoses", f"{len(paths)} given", "two or more")
    return [Named(name, _read(path)) for name, path in zip(_names(paths), paths)]


def write_comparison(diagnoses: Sequence[Named], folder: str | Path) -> Path:
    """Write ``comparison.html`` into the folder (made if missing), whole or not at all."""
    path = output_folder(Path(folder)) / FILE
    write_whole(path, page(diagnoses))
    return path


def page(diagnoses: Sequence[Named]) -> str:
    """The page as HTML; every text of the files is escaped."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("gapscope.analysis.gap.report", ""),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    effects = _effects(diagnoses)
    return environment.get_template("compare.html").render(
        headline=headline(diagnoses),
        rows=[_row(d) for d in diagnoses],
        effects=[
            (effect, _meaning(effect), [_cell(d, effect) for d in diagnoses]) for effect in effects
        ],
        names=[d.name for d in diagnoses],
        no_gap=listed(d.name for d in diagnoses if d.content["verdict"] == "no_gap"),
        joints=_shares(diagnoses, "joints"),
        regimes=_shares(diagnoses, "regimes"),
        bands=_shares(diagnoses, "bands"),
        warnings=[(d.name, d.content["warnings"]) for d in diagnoses],
        provenance=[(d.name, _provenance(d.content["provenance"])) for d in diagnoses],
    )


def _provenance(pairs: Mapping[str, Any]) -> dict[str, Any]:
    """As they are; fractions such as the seconds it took to four digits."""
    return {k: number(v, digits=4) if isinstance(v, float) else v for k, v in pairs.items()}


def _meaning(effect: str) -> str:
    """What an effect id stands for; empty for one outside the catalogue of drives."""
    known = catalogue().get(effect)
    return known.summary.split(";")[0] if known else ""


def headline(diagnoses: Sequence[Named]) -> str:
    """What the diagnoses have in common and where they part, in words."""
    counts = Counter(VERDICTS[d.content["verdict"]] for d in diagnoses)
    verdicts = listed(f"{count} {name}" for name, count in counts.items())
    found = [{e["id"] for e in d.content["effects"]} for d in diagnoses]
    everywhere = set.intersection(*found)
    somewhere = set.union(*found) - everywhere
    parts = [f"Of {len(diagnoses)} diagnoses: {verdicts}."]
    if everywhere:
        parts.append(f"Named in every one: {listed(sorted(everywhere))}.")
    if somewhere:
        parts.append(f"Only in some: {listed(sorted(somewhere))}.")
    if not everywhere and not somewhere:
        parts.append("No effect is named in any.")
    return " ".join(parts)


def _read(path: Path) -> dict[str, Any]:
    file = path / "diagnosis.json" if path.is_dir() else path
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(
            file, str(error.strerror), "the result of a diagnosis", "Run `gapscope diagnose` first."
        ) from None
    except ValueError as error:
        raise InputError(file, f"not JSON ({error})", "a diagnosis.json") from None
    missing = [key for key in NEEDED if not isinstance(content, dict) or key not in content]
    if missing:
        raise InputError(file, f"has no key {missing[0]!r}", "a diagnosis.json of this version")
    if content["verdict"] not in VERDICTS:
        raise InputError(
            file, f"verdict is {content['verdict']!r}", f"one of {', '.join(VERDICTS)}"
        )
    return content


def _names(paths: Sequence[Path]) -> list[str]:
    """The shortest ends of the paths that tell them apart."""
    folders = [(p if p.is_dir() else p.parent).resolve().parts for p in paths]
    for length in range(1, max(map(len, folders)) + 1):
        names = ["/".join(parts[-length:]) for parts in folders]
        if len(set(names)) == len(names):
            return names
    raise InputError("compare diagnoses", "the same one is given twice", "different ones")


def _effects(diagnoses: Sequence[Named]) -> list[str]:
    counts = Counter(e["id"] for d in diagnoses for e in d.content["effects"])
    return [effect for effect, _ in sorted(counts.items(), key=lambda item: (-item[1], item[0]))]


def _row(d: Named) -> dict[str, Any]:
    s = d.content["shrinkage"]
    levels = {name: s.get(name) for name in ("before", "retuned", "after", "floor")}
    ends = s.get("intervals_ci95") or {}
    top = max((v for v in levels.values() if v), default=1.0)
    weakest = min((e["probability"] for e in d.content["effects"]), default=None)
    return {
        "name": d.name,
        "kind": d.content["verdict"],
        "verdict": VERDICTS[d.content["verdict"]],
        "confidence": "" if weakest is None else confidence(weakest),
        "percent": "–" if s.get("percent") is None else f"{s['percent']:.1f} %",
        "interval": "" if not s.get("ci95") else interval(s["ci95"], "%"),
        "metric": s.get("metric", ""),
        "levels": [
            (
                name,
                "–" if v is None else number(v),
                interval(ends[name]) if ends.get(name) else "",
                0.0 if v is None else 100.0 * v / top,
            )
            for name, v in levels.items()
        ],
    }


def _cell(d: Named, effect: str) -> dict[str, Any] | None:
    found = next((e for e in d.content["effects"] if e["id"] == effect), None)
    if found is None:
        return None
    places = [str(p) for v in found["where"].values() for p in (v if isinstance(v, list) else [v])]
    values = [
        f"{name} {number(p['value'], p.get('unit', ''))}"
        for name, p in found["parameters"].items()
        if isinstance(p, dict) and isinstance(p.get("value"), int | float)
    ]
    return {
        "probability": percent(found["probability"], 1),
        "places": listed(places),
        "values": "; ".join(values),
    }


def _shares(diagnoses: Sequence[Named], key: str) -> dict[str, Any]:
    """Heat map of a list of shares: diagnoses by the names in it."""
    tables = [
        {r["name"]: r["share"] for r in d.content["location"].get(key, [])} for d in diagnoses
    ]
    columns = list(dict.fromkeys(name for table in tables for name in table))
    return {
        "columns": columns,
        "rows": [
            (d.name, [(percent(t.get(c)), round(t.get(c) or 0.0, 3)) for c in columns])
            for d, t in zip(diagnoses, tables)
        ],
    }
