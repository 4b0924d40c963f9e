"""What the instrument says of a collection of log sets, as one page of Markdown.

Every number of the page is taken from the ``diagnosis.json`` of the run that writes it. A set that cannot
be read, for instance because no machine of its kind is known, is listed with the error line.
"""

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..files import output_folder, write_whole
from ..resumable import resumable_map
from .description import FILE

REJECTED = 4  # hypotheses of the ranking that are listed beside the accepted one
PLACES = 2  # largest shares of the gap that are listed of each kind
WHERE = ("joints", "regimes", "bands", "runs")  # kinds of shares that are listed

Case = dict[str, Any]


def log_sets(folder: Path) -> list[Path]:
    """Log sets right below a folder, by name; InputError if it holds none."""
    found = sorted(path.parent for path in folder.glob(f"*/{FILE}"))
    if not found:
        raise InputError(folder, "no log sets", f"folders with a file {FILE}")
    return found


def diagnose_case(folder: str, seed: int) -> Case:
    """The diagnosis of one log set, or the error that ends it, as JSON values."""
    from .diagnosis import diagnose

    path = Path(folder)
    started = time.perf_counter()
    try:
        found = diagnose(path, seed=seed)
    except InputError as error:
        return {
            "name": path.name,
            "error": str(error).replace(str(path), path.name).splitlines()[0],
        }
    return {
        "name": path.name,
        "kind": found.machine.kind,
        "unit": found.machine.residual_unit,
        "effort_unit": found.machine.effort_unit,
        "seconds": time.perf_counter() - started,
        "result": found.to_json(),
    }


def write_cases(
    sections: Sequence[tuple[str, Sequence[Path]]],
    out: Path,
    work: Path,
    *,
    seed: int = 0,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Path:
    """Diagnose the log sets of every (title, folders) and write the page ``out``.

    Finished diagnoses are kept in the folder ``work``, where a second call takes them up.
    """
    folders = [folder for _, group in sections for folder in group]
    cases = [{"folder": str(folder), "seed": seed} for folder in folders]
    results = iter(resumable_map(diagnose_case, cases, work, progress=progress))
    grouped = [(title, [next(results) for _ in group]) for title, group in sections]
    write_whole(output_folder(out.parent) / out.name, page(grouped))
    return out


def page(sections: Sequence[tuple[str, Sequence[Case]]]) -> str:
    """The page as Markdown, from (title, cases) in the order given."""
    lines = [
        "# What the instrument says of the log sets at hand",
        "",
        "Written by `gapscope cases`; do not edit. Shrinkage is the share of the explainable gap that is "
        "removed on runs which were never used to fit or to choose, with a block-bootstrap interval of "
        "95 %. Where the verdict accepts nothing, the model is the retuned nominal one. Times are of the "
        "machine that wrote the page, whatever else it was doing.",
        "",
        *_summary(sections),
    ]
    for title, cases in sections:
        lines += ["", f"## {title}"]
        for case in cases:
            lines += ["", *_case(case)]
    return "\n".join(lines) + "\n"


def _summary(sections: Sequence[tuple[str, Sequence[Case]]]) -> list[str]:
    lines = [
        "| set | kind | verdict | effects | gap removed | time | simulations |",
        "|---|---|---|---|---|---|---|",
    ]
    for _, cases in sections:
        for case in cases:
            if "error" in case:
                lines.append(f"| {case['name']} | | not diagnosed | | | | |")
                continue
            r = case["result"]
            effects = ", ".join(e["id"] for e in r["effects"]) or "none"
            removed = _percent(r["shrinkage"])
            if r.get("leading"):
                effects += f" accepted; best is {' + '.join(r['leading']['ids'])}"
                removed += f"; best {_percent(r['leading'])}"
            lines.append(
                f"| {case['name']} | {case['kind']} | {r['verdict']} | {effects} "
                f"| {removed} | {case['seconds']:.1f} s "
                f"| {r['provenance']['simulations']} |"
            )
    return lines


def _case(case: Case) -> list[str]:
    if "error" in case:
        return [f"### {case['name']}", "", f"Not diagnosed: {case['error']}"]
    r = case["result"]
    return [
        f"### {case['name']}: {r['verdict']}",
        "",
        r["reason"],
        "",
        *_effects(r["effects"]),
        *_leading(r, case),
        f"- Where: {_where(r['location'])}.",
        f"- Shrinkage, {r['shrinkage']['metric']} ({', '.join(r['shrinkage']['runs'])}): "
        f"before {_number(r['shrinkage']['before'])}, retuned {_number(r['shrinkage']['retuned'])}, "
        f"after {_number(r['shrinkage']['after'])}, floor {_number(r['shrinkage']['floor'])}; "
        f"{_percent(r['shrinkage'])} removed.",
        f"- Floor: {r['shrinkage']['floor_source']}.",
        *_loops(r["shrinkage"].get("closed_loop") or {}),
        f"- Cost: {case['seconds']:.1f} s, {r['provenance']['simulations']} simulations; seed "
        f"{r['provenance']['seed']}, data {r['provenance']['sha256'][:12]}.",
        *_rejected(r, case["unit"]),
        *(f"- Note: {warning}" for warning in r["warnings"]),
    ]


def _effects(effects: Sequence[dict[str, Any]]) -> list[str]:
    if not effects:
        return []
    lines = ["| effect | form | where | probability | parameters |", "|---|---|---|---|---|"]
    for e in effects:
        lines.append(
            f"| {e['id']} | {e['form']} | {_places(e['where'])} | {e['probability']:.3f} "
            f"| {_parameters(e['parameters'])} |"
        )
    return [*lines, ""]


def _places(where: dict[str, Any]) -> str:
    return ", ".join(str(place) for places in where.values() for place in places)


def _leading(r: dict[str, Any], case: Case) -> list[str]:
    """The best hypothesis where none was accepted, with what it would do."""
    leading = r.get("leading")
    if not leading:
        return []
    forms = " + ".join(f"{i} ({f})" for i, f in zip(leading["ids"], leading["forms"]))
    values = "; ".join(
        f"{_places(leading['where'][effect])}: {_parameters(p)}"
        for effect, p in leading["parameters"].items()
    )
    line = (
        f"- Best hypothesis, not accepted: {forms}, {values}. On the held-out runs it leaves "
        f"{_number(leading['after'])} {case['effort_unit']} unexplained, {_percent(leading)} removed"
    )
    loop = leading.get("closed_loop")
    return [line + (f"; closed loop: {_loop(loop)}." if loop else ".")]


def _rejected(r: dict[str, Any], unit: str) -> list[str]:
    said = {e["id"] for e in r["effects"]} or set((r.get("leading") or {"ids": []})["ids"])
    lines = []
    for ranked in r["ranking"]:
        if set(ranked["ids"]) == said and said:
            continue
        name = " + ".join(ranked["ids"]) or "nothing but retuning"
        lines.append(
            f"- Not accepted: {name}; error {_number(ranked['held_out_error'])} {unit} on held-out pieces of the fit "
            f"runs, probability {ranked['probability']:.3f}."
        )
    return lines[:REJECTED]


def _where(location: dict[str, list[dict[str, Any]]]) -> str:
    parts = []
    for kind in WHERE:
        entries = location.get(kind, [])
        named = [e for e in entries if "name" in e and e.get("share") is not None]
        if len(named) < 2:
            continue
        largest = sorted(named, key=lambda e: -e["share"])[:PLACES]
        shares = ", ".join(f"{e['name']} {100 * e['share']:.0f} %" for e in largest)
        parts.append(f"{kind}: {shares}")
    return "; ".join(parts) or "one signal only"


def _loops(loops: dict[str, Any]) -> list[str]:
    if not loops:
        return ["- Closed loop: no controller to simulate."]
    said = [f"{name} {_loop(loop)}" for name, loop in loops.items()]
    return [f"- Closed loop on the held-out runs: {'; '.join(said)}."]


def _loop(loop: dict[str, float] | None) -> str:
    if loop is None:
        return "diverges"
    return ", ".join(f"{key.replace('_', ' ')} {_number(value)}" for key, value in loop.items())


def _parameters(parameters: dict[str, dict[str, Any]]) -> str:
    said = []
    for name, p in parameters.items():
        interval = p.get("ci95")
        around = f" [{_number(interval[0])}, {_number(interval[1])}]" if interval else ""
        unit = "" if p["unit"] == "-" else f" {p['unit']}"
        said.append(f"{name} = {_number(p['value'])}{around}{unit}")
    return ", ".join(said)


def _percent(s: dict[str, Any]) -> str:
    if s.get("percent") is None:
        return "nothing to remove"
    low, high = s["ci95"]
    return f"{s['percent']:.1f} % [{low:.1f}, {high:.1f}]"


def _number(value: float) -> str:
    return f"{value:.3g}"
