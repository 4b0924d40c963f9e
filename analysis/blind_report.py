"""The score of a blind run on paper: ``blind.json``, ``blind.md`` and four figures."""

import dataclasses
import io
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg", force=False)
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from . import blind_check, blind_rates, blind_score, blind_statistics
from .blind_score import Outcome
from .blind_statistics import Estimate
from .files import write_whole

BLUE, ORANGE, GREEN, VERMILION = "#0072B2", "#E69F00", "#009E73", "#D55E00"  # Okabe and Ito
TARGETS = (  # what, key, bound, is a lower bound, in percent
    ("top-1, visible effects", "top1", 0.95, True, True),
    ("top-1, counting a delay and a lag both named as right", "top1_late", 0.95, True, True),
    ("false alarms without effect", "false_alarms", 0.0, False, True),
    ("off the library: unknown or abstained", "off_library_withheld", 0.90, True, True),
    ("median share of the explainable gap removed", "removed_percent", 90.0, True, False),
    ("expected calibration error", "ece", 0.05, False, False),
)
RATES = (
    ("top-1, or ambiguous with the answer among the two named", "top1_or_twins"),
    ("top-2, visible effects", "top2"),
    ("top-1, single effects", "top1_single"),
    ("top-2, single effects", "top2_single"),
    ("top-1, pairs (both, nothing else)", "top1_double"),
    ("pairs: at least one named", "double_at_least_one"),
    ("pairs: nothing wrong named", "double_nothing_wrong"),
    ("claimed and right", "named"),
    ("claimed and wrong", "wrong_claims"),
    ("abstained (unexplained, ambiguous, no gap)", "abstentions"),
    ("ambiguous with the answer among the two named", "rightly_ambiguous"),
    ("off the library: claimed a mechanism (false attribution)", "off_library_false"),
    ("off the library: no gap", "off_library_no_gap"),
    ("faint effects (below 5 x floor): top-1", "top1_faint"),
    ("faint effects: claimed and wrong", "wrong_claims_faint"),
    ("diagnoses that failed", "failed"),
)


def write(outcomes: Sequence[Outcome], *, seed: int, digest: str, out: Path) -> dict[str, Any]:
    """Write all of the report into ``out``; return the content of ``blind.json``."""
    numbers = blind_rates.summary(outcomes)
    content = {
        "seed": seed,
        "use": blind_check.label(seed),
        "sealed_sha256": digest,
        "summary": _plain(numbers),
        "cases": [_plain(dataclasses.asdict(o)) for o in outcomes],
    }
    write_whole(out / "blind.json", json.dumps(content, indent=1) + "\n")
    write_whole(out / "blind.md", markdown(outcomes, numbers, seed=seed, digest=digest))
    figures: dict[str, Callable[[Sequence[Outcome]], Figure]] = {
        "confusion": draw_confusion,
        "calibration": draw_calibration,
        "risk_coverage": draw_risk_coverage,
        "shrinkage": draw_shrinkage,
    }
    for name, draw in figures.items():
        buffer = io.BytesIO()
        with plt.rc_context(
            {"font.size": 9.0, "axes.spines.top": False, "axes.spines.right": False}
        ):
            figure = draw(outcomes)
            figure.savefig(buffer, format="png", dpi=150)
            plt.close(figure)
        write_whole(out / f"{name}.png", buffer.getvalue())
    return content


def _plain(value: Any) -> Any:
    """JSON-ready copy: estimates and sets opened, nan as null."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return _plain(dataclasses.asdict(value))
    if isinstance(value, dict):
        return {key: _plain(v) for key, v in value.items()}
    if isinstance(value, frozenset):
        return sorted(value)
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def markdown(
    outcomes: Sequence[Outcome], numbers: dict[str, Any], *, seed: int, digest: str
) -> str:
    """The report as text: targets, rates, per mechanism, off the library, wrong cases."""
    counts = numbers["cases"]
    told = ", ".join(
        f"{k.replace('_', ' ')} {c['all']} ({c['visible']} visible)" for k, c in counts.items()
    )
    lines = [
        f"# Blind check, seed {seed} ({blind_check.label(seed)})",
        "",
        f"{len(outcomes)} cases: {told}. Seal of the answers: `{digest}`.",
        f"Visible: every effect of the case moves the residual by at least {blind_score.VISIBLE:g} x the floor.",
        "Intervals are 95 % (Wilson for shares, percentile bootstrap otherwise).",
        "",
        "| target | reached | wanted | n | met |",
        "|---|---|---|---|---|",
    ]
    for what, key, bound, lower, percent in TARGETS:
        lines.append(_target(what, numbers[key], bound, lower, percent))
    lines += ["", "| rate | value | n |", "|---|---|---|"]
    lines += [f"| {what} | {_percent(numbers[key])} | {numbers[key].n} |" for what, key in RATES]
    lines += [
        f"| claimed minus attainable shrinkage, median size (percentage points) | {_number(numbers['shrinkage_error_percent'])} | {numbers['shrinkage_error_percent'].n} |",
        f"| share of the explainable gap removed, abstentions counted as none, median (%) | {_number(numbers['removed_of_all_percent'])} | {numbers['removed_of_all_percent'].n} |",
        f"| expected calibration error of all claims, faint, off-library and no-effect cases too | {_number(numbers['ece_all'])} | {numbers['ece_all'].n} |",
        f"| seconds a diagnosis, median | {_number(numbers['seconds'])} | {numbers['seconds'].n} |",
        "",
        "## By mechanism (single effects)",
        "",
        "| mechanism | top-1 | top-2 | visible | faint |",
        "|---|---|---|---|---|",
    ]
    for name, row in numbers["by_mechanism"].items():
        top1, top2 = _percent(row["top1"]), _percent(row["top2"])
        lines.append(f"| {name} | {top1} | {top2} | {row['top1'].n} | {row['faint']} |")
    lines += ["", "## Off the library", "", "| cause | no mechanism claimed | n |", "|---|---|---|"]
    lines += [f"| {n} | {_percent(e)} | {e.n} |" for n, e in numbers["by_off_library"].items()]
    lines += [
        "",
        "## Parameters that can be compared (median relative error, rightly named cases)",
        "",
    ]
    if numbers["parameters"]:
        lines += ["| parameter | error | n |", "|---|---|---|"]
        lines += [f"| {key} | {_number(e)} | {e.n} |" for key, e in numbers["parameters"].items()]
    else:
        lines.append("None.")
    return "\n".join([*lines, "", *_mistakes(outcomes)]) + "\n"


def _mistakes(outcomes: Sequence[Outcome]) -> list[str]:
    lines = ["## Visible cases answered otherwise", ""]
    wrong = [o for o in outcomes if o.visible and not o.right]
    if not wrong:
        return [*lines, "None."]
    lines += ["| case | cause | strength | verdict | first hypothesis |", "|---|---|---|---|---|"]
    for o in wrong:
        cause = ", ".join(o.cause) or "none"
        said = o.error or ", ".join(sorted(o.first)) or "no effect"
        lines.append(f"| {o.name} | {cause} | {o.strength:.1f} | {o.verdict} | {said} |")
    return lines


def _target(what: str, e: Estimate, bound: float, lower: bool, percent: bool) -> str:
    met = (
        "no case"
        if e.n == 0
        else "yes"
        if (e.value >= bound if lower else e.value <= bound)
        else "no"
    )
    scale, unit = (100.0, " %") if percent else (1.0, "")
    wanted = f"{'>=' if lower else '<='} {scale * bound:g}{unit}"
    return f"| {what} | {_percent(e) if percent else _number(e)} | {wanted} | {e.n} | {met} |"


def _percent(e: Estimate) -> str:
    if e.n == 0:
        return "-"
    return f"{100 * e.value:.0f} % [{100 * e.low:.0f}, {100 * e.high:.0f}]"


def _number(e: Estimate) -> str:
    return "-" if e.n == 0 else f"{e.value:.3g} [{e.low:.3g}, {e.high:.3g}]"


def draw_confusion(outcomes: Sequence[Outcome]) -> Figure:
    """Which mechanism is taken for which? Counts, visible single, off-library and no-effect cases."""
    shown = [o for o in outcomes if o.visible]
    truths, predictions, counts = blind_score.confusion(shown)
    figure, axes = plt.subplots(figsize=(9.5, 8.0), layout="constrained")
    axes.imshow(
        counts / np.maximum(counts.sum(axis=1, keepdims=True), 1), cmap="Blues", vmin=0, vmax=1
    )
    for row, column in np.argwhere(counts > 0):
        dark = counts[row, column] > 0.6 * counts[row].sum()
        axes.text(
            column,
            row,
            str(counts[row, column]),
            ha="center",
            va="center",
            color="white" if dark else "black",
        )
    axes.set_xticks(range(len(predictions)), predictions, rotation=60, ha="right")
    axes.set_yticks(range(len(truths)), truths)
    axes.set_xlabel("said")
    axes.set_ylabel("true")
    axes.set_title("Cases by true and stated mechanism (shade: share of the row)")
    return figure


def draw_calibration(outcomes: Sequence[Outcome]) -> Figure:
    """Is a stated probability the frequency of being right? Visible cases with a probability."""
    pairs = [
        (o.confidence, float(o.right)) for o in outcomes if o.visible and o.confidence is not None
    ]
    figure, axes = plt.subplots(figsize=(5.0, 4.5), layout="constrained")
    axes.plot([0, 1], [0, 1], color="0.6", linewidth=1, label="calibrated")
    if pairs:
        rows = np.array(pairs, dtype=float)
        for _, confidence, accuracy, count in blind_statistics.reliability(rows):
            e = blind_statistics.proportion(
                [True] * round(accuracy * count) + [False] * round((1 - accuracy) * count)
            )
            axes.errorbar(
                confidence,
                accuracy,
                yerr=[[accuracy - e.low], [e.high - accuracy]],
                fmt="o",
                color=BLUE,
                capsize=3,
            )
            axes.annotate(
                f"n = {count}", (confidence, accuracy), (6, -10), textcoords="offset points"
            )
        axes.set_title(f"Expected calibration error {blind_statistics.calibration_error(rows):.3f}")
    axes.set_xlabel("stated probability [-]")
    axes.set_ylabel("share right [-], 95 % Wilson")
    axes.set_xlim(-0.02, 1.12)
    axes.set_ylim(-0.02, 1.02)
    axes.legend(frameon=False)
    return figure


def draw_risk_coverage(outcomes: Sequence[Outcome]) -> Figure:
    """What does answering more cost? Wrong share among claims against the share of cases claimed."""
    curve = blind_score.risk_coverage([o for o in outcomes if o.visible])
    figure, axes = plt.subplots(figsize=(5.0, 4.0), layout="constrained")
    if curve:
        coverage, risk = np.array(curve).T
        axes.step(100 * coverage, 100 * risk, where="post", color=BLUE)
        axes.plot(100 * coverage[-1], 100 * risk[-1], "o", color=VERMILION, label="all claims made")
        axes.legend(frameon=False)
    axes.set_xlim(0, 100)
    axes.set_ylim(bottom=0)
    axes.set_xlabel("cases with a gap that are given a mechanism [%]")
    axes.set_ylabel("of these, wrong [%]")
    axes.set_title("Most confident claims first")
    return figure


def draw_shrinkage(outcomes: Sequence[Outcome]) -> Figure:
    """Is the claimed shrinkage what the true machine's model attains? Visible claimed cases."""
    figure, axes = plt.subplots(figsize=(5.0, 4.5), layout="constrained")
    axes.plot([0, 110], [0, 110], color="0.6", linewidth=1)
    for right, colour, text in (
        (True, BLUE, "right mechanism"),
        (False, VERMILION, "wrong mechanism"),
    ):
        points = [
            (o.attainable, o.shrinkage)
            for o in outcomes
            if o.visible
            and o.claimed
            and o.right == right
            and o.shrinkage is not None
            and o.attainable is not None
        ]
        if points:
            axes.plot(*np.array(points).T, "o" if right else "x", color=colour, label=text)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(frameon=False)
    axes.set_xlabel("attainable with the true machine's model [%]")
    axes.set_ylabel("claimed shrinkage on validation runs [%]")
    axes.set_xlim(0, 110)
    axes.set_ylim(0, 110)
    return figure
