"""``report.html`` of the thesis diagnosis: self-contained, one picture, then the evidence."""

from __future__ import annotations

import json
from importlib.resources import files as package_files
from typing import TYPE_CHECKING, Any

import jinja2

from ...figures import inline_svg
from .figure import measured_and_models

if TYPE_CHECKING:
    from .carry_over import CarryOver
    from .result import ThesisDiagnosis

QUESTION = "Does what fits the 2 Hz experiment predict the 1 Hz experiment?"


def page(diagnosis: ThesisDiagnosis) -> str:
    """The report as one HTML document."""
    d = diagnosis
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
    source = package_files("gapscope.analysis").joinpath("templates/thesis.html").read_text()
    return environment.from_string(source).render(
        verdict=d.verdict.verdict,
        reason=d.verdict.reason,
        shrinkage=shrinkage_text(d),
        location=location_text(d),
        question=QUESTION,
        figure=inline_svg(
            lambda: measured_and_models(d.entries, best_label(d)),
            name="thesis",
            description=QUESTION,
        ),
        tables=[_ranking(d), _gap_by_place(d), _remaining(d), _observations(d), _variants(d)],
        identifiability=identifiability_text(d),
        next_experiment=next_text(d),
        warnings=d.warnings,
        provenance=json.dumps(d.provenance, indent=2),
    )


def best_label(d: ThesisDiagnosis) -> str:
    """What the figure calls the best hypothesis at 2 Hz."""
    if d.best.hypothesis.forms == ():
        return "retuned nominal model"
    standing = "refuted by 1 Hz" if d.refuted[0] else d.verdict.verdict
    return f"best fit at 2 Hz: {' + '.join(d.best.hypothesis.ids)} ({standing})"


def shrinkage_text(d: ThesisDiagnosis) -> str:
    """How far the gap shrinks on the held-out table, in two sentences."""
    s, b = d.shrinkage, d.best_carry_over
    text = (
        f"Held-out 1 Hz table, rms relative error of its 27 values: nominal {_percent(s.before)}, retuned "
        f"{_percent(s.retuned)}, with the accepted effects {_percent(s.after)}, scatter between replicate "
        f"tests {_percent(s.floor)}. Share of the gap removed: {_share(s)}."
    )
    if d.verdict.accepted is None and d.best.hypothesis.forms:
        text += (
            f" The best fit at 2 Hz, {' + '.join(d.best.hypothesis.ids)}, was not accepted; it gives "
            f"{_percent(b.after)} at 1 Hz. Share of the gap removed: {_share(b)}."
        )
    return text


def location_text(d: ThesisDiagnosis) -> str:
    """Where the gap lies at either rate, in two sentences."""
    controller, metric = d.location["controllers"][0], d.location["signals"][0]
    motions = [f"{name} {_percent(before)}" for name, (before, _) in d.shrinkage.by_motion.items()]
    return (
        f"At 2 Hz, {100 * controller['share']:.0f} % of the gap is in the tests of "
        f"{controller['name'].upper()} and {100 * metric['share']:.0f} % in {metric['name']}. At 1 Hz the "
        f"nominal model errs by motion: {', '.join(motions)}; tests scatter by "
        f"{_percent(d.scatter.relative)} at 2 Hz and {_percent(d.shrinkage.floor)} at 1 Hz."
    )


def identifiability_text(d: ThesisDiagnosis) -> str:
    """What 27 numbers determine of all candidate parameters."""
    i = d.identifiability
    text = (
        f"Of {i.parameters} parameters of the candidate effects, the 27 RMS values determine "
        f"{i.determined} combinations to better than half their typical size. "
    )
    if i.alike:
        pairs = "; ".join(f"{a} and {b} ({cosine:.2f})" for a, b, cosine in i.alike[:6])
        text += f"Alike in all values (cosine): {pairs}. "
    if i.invisible:
        text += f"Not visible near zero: {', '.join(i.invisible)}."
    return text


def next_text(d: ThesisDiagnosis) -> str:
    """The next experiment in words."""
    n, run = d.next_experiment, d.next_experiment["run"]
    first, second = (" + ".join(ids) or "the retuned nominal model" for ids in n["separates"])
    return (
        f"{run['controller'].upper()}, {run['motion']}, {run['rate_Hz']:g} Hz: {first} and {second} differ "
        f"there by {n['prediction_difference']:.0f} standard deviations in {run['metric']}. {n['note']}"
    )


def _ranking(d: ThesisDiagnosis) -> dict[str, Any]:
    rows = []
    for r, error, gone in zip(d.ranking, d.held_out_errors, d.refuted):
        low, high = r.gain_interval
        rows.append(
            [
                r.fit.hypothesis.label,
                f"{r.probability:.3f}",
                _percent(r.fit.rms),
                _percent(r.fit.held_out_rms),
                f"{r.gain:.2f} [{low:.2f}, {high:.2f}]",
                _percent(error),
                "refuted" if gone else "",
            ]
        )
    return {
        "name": "ranking",
        "title": "Every hypothesis, best first by motions and controllers left out at 2 Hz",
        "note": "Probability: how often a hypothesis wins when the nine tests are resampled. Gain: fall of "
        "the log error against the retuned nominal, 95 % interval. The 1 Hz table took no part "
        "in fitting or ranking; what predicts it worse than the retuned nominal is refuted.",
        "header": (
            "hypothesis", "probability", "fitted, 2 Hz", "left out, 2 Hz", "gain", "held out, 1 Hz", "",
        ),
        "rows": rows,
    }  # fmt: skip


def _gap_by_place(d: ThesisDiagnosis) -> dict[str, Any]:
    b = d.best_carry_over
    parts = {"signals": b.by_metric, "regimes": b.by_motion, "controllers": b.by_controller}
    rows = []
    for kind, held_out in parts.items():
        for share in d.location[kind]:
            before, after = held_out[share["name"]]
            rows.append(
                [share["name"], f"{100 * share['share']:.0f} %", _percent(before), _percent(after)]
            )
    return {
        "name": "location",
        "title": "Where the gap is",
        "note": "Shares of the squared relative error of the retuned nominal model at 2 Hz, and relative "
        "errors at 1 Hz.",
        "header": (
            "metric, motion, controller",
            "share at 2 Hz",
            "nominal, 1 Hz",
            "best fit, 1 Hz",
        ),
        "rows": rows,
    }


def _remaining(d: ThesisDiagnosis) -> dict[str, Any]:
    def size(model: float, measured: float, deviation: float) -> float:
        return (model - measured) / deviation

    far = [
        (e, size(e.retuned, e.measured, e.deviation), size(e.best, e.measured, e.deviation))
        for e in d.entries
    ]
    far = [row for row in far if abs(row[1]) > 2.0]
    far.sort(key=lambda row: -abs(row[1]))
    return {
        "name": "remaining",
        "title": "What the retuned nominal model leaves unexplained (over 2 standard deviations)",
        "note": "",
        "header": (
            "test", "metric", "experiment", "retuned nominal", "deviations", "best fit at 2 Hz",
            "deviations",
        ),
        "rows": [
            [
                f"{e.controller.upper()} {e.motion}, {e.rate_Hz:g} Hz", e.metric, f"{e.measured:.4f}",
                f"{e.retuned:.4f}", f"{nominal:+.1f}", f"{e.best:.4f}", f"{best:+.1f}",
            ]
            for e, nominal, best in far
        ],
    }  # fmt: skip


def _observations(d: ThesisDiagnosis) -> dict[str, Any]:
    expected = {"superposition": "{:.2f}", "torque bound": "at most {:.4f}", "cross axis": "0"}
    rows = [
        [
            o.kind, f"{o.controller.upper()}, {o.rate_Hz:g} Hz", o.quantity, f"{o.value:.4g}",
            expected[o.kind].format(o.expected), f"{o.deviation:.1f}", "yes" if o.significant else "",
        ]
        for o in sorted(d.observations, key=lambda o: -o.deviation)
    ]  # fmt: skip
    return {
        "name": "observations",
        "title": "What the printed experiment says without any model",
        "note": "Every linear drive with like sides has half of each pure motion's error in helical motion, "
        "torques below a bound, and no error across the axis.",
        "header": (
            "kind",
            "test",
            "quantity",
            "value",
            "linear drive",
            "deviations",
            "significant",
        ),
        "rows": rows,
    }


def _variants(d: ThesisDiagnosis) -> dict[str, Any]:
    return {
        "name": "variants",
        "title": "Does the choice of the nominal simulation matter?",
        "note": "",
        "header": ("simulation without any effect", "2 Hz", "1 Hz"),
        "rows": [
            [name, *("–" if value is None else _percent(value) for value in errors.values())]
            for name, errors in d.variants.items()
        ],
    }


def _share(c: CarryOver) -> str:
    if c.percent is None or c.ci95 is None:
        return "nothing lies above the floor"
    return f"{c.percent:.0f} % (95 % interval {c.ci95[0]:.0f} to {c.ci95[1]:.0f} %; negative: it grows)"


def _percent(value: float) -> str:
    return f"{100 * value:.1f} %"
