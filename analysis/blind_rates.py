"""Every number of a blind run's score, with its interval."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from .blind_score import AMBIGUOUS, FAILED, NO_GAP, UNEXPLAINED, UNKNOWN, Outcome
from .blind_statistics import Estimate, bootstrapped, calibration_error, median, proportion


def summary(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Every number of the score, as JSON-ready dictionaries of estimates."""
    visible = [o for o in outcomes if o.visible]
    gaps = [o for o in visible if o.kind in ("single", "double")]
    faint = [o for o in outcomes if not o.visible and o.kind in ("single", "double")]
    return {
        "cases": {
            kind: {
                "all": sum(o.kind == kind for o in outcomes),
                "visible": sum(o.kind == kind for o in visible),
            }
            for kind in ("none", "single", "double", "off_library")
        },
        **_accuracy(gaps),
        **_claims(gaps),
        **_withheld(outcomes),
        "failed": proportion([o.verdict == FAILED for o in outcomes]),
        "top1_faint": proportion([o.right for o in faint]),
        "wrong_claims_faint": proportion([o.claimed and not o.right for o in faint]),
        "ece": _calibration(visible),
        "ece_all": _calibration(outcomes),
        **_shrinkage(gaps),
        "seconds": bootstrapped(median, [[o.seconds] for o in outcomes]),
        "by_mechanism": _by_mechanism(outcomes),
        "by_off_library": {
            name: proportion([not o.claimed for o in visible if o.cause == (name,)])
            for name in sorted({o.cause[0] for o in outcomes if o.kind == "off_library"})
        },
        "parameters": _parameter_errors(outcomes),
    }


def _accuracy(gaps: Sequence[Outcome]) -> dict[str, Estimate]:
    """How often the first hypothesis, or one of two, is the answer."""
    single = [o for o in gaps if o.kind == "single"]
    double = [o for o in gaps if o.kind == "double"]
    return {
        "top1": proportion([o.right for o in gaps]),
        "top1_late": proportion([o.right or o.names_both_late for o in gaps]),
        "top1_or_twins": proportion(
            [o.right or (o.verdict == AMBIGUOUS and o.truth in o.named) for o in gaps]
        ),
        "top2": proportion([o.right_in_two for o in gaps]),
        "top1_single": proportion([o.right for o in single]),
        "top2_single": proportion([o.right_in_two for o in single]),
        "top1_double": proportion([o.right for o in double]),
        "double_at_least_one": proportion([bool(o.first & o.truth) for o in double]),
        "double_nothing_wrong": proportion([o.first <= o.truth for o in double]),
    }


def _claims(gaps: Sequence[Outcome]) -> dict[str, Estimate]:
    """How often a mechanism is claimed, rightly or wrongly, or nothing is."""
    unsure = [o for o in gaps if o.verdict == AMBIGUOUS]
    return {
        "named": proportion([o.claimed and o.right for o in gaps]),
        "wrong_claims": proportion([o.claimed and not o.right for o in gaps]),
        "abstentions": proportion([o.verdict in (UNEXPLAINED, AMBIGUOUS, NO_GAP) for o in gaps]),
        "rightly_ambiguous": proportion([o.truth in o.named for o in unsure]),
    }


def _withheld(outcomes: Sequence[Outcome]) -> dict[str, Estimate]:
    """What is said where no effect, or none that an id stands for, is the answer."""
    none = [o for o in outcomes if o.kind == "none"]
    off = [o for o in outcomes if o.visible and o.kind == "off_library"]
    return {
        "false_alarms": proportion([o.verdict != NO_GAP for o in none]),
        "off_library_withheld": proportion(
            [o.verdict in (UNEXPLAINED, AMBIGUOUS) or o.first == UNKNOWN for o in off]
        ),
        "off_library_false": proportion([o.claimed for o in off]),
        "off_library_no_gap": proportion([o.verdict == NO_GAP for o in off]),
    }


def _calibration(outcomes: Sequence[Outcome]) -> Estimate:
    """Expected calibration error of all that was said with a probability."""
    said = [(o.confidence, float(o.right)) for o in outcomes if o.confidence is not None]
    return bootstrapped(calibration_error, said)


def _shrinkage(gaps: Sequence[Outcome]) -> dict[str, Estimate]:
    """How far the gap shrank on validation runs, and by how much another share was attainable."""
    removed = [[o.shrinkage] for o in gaps if o.claimed and o.shrinkage is not None]
    of_all = [[(o.shrinkage or 0.0) if o.claimed else 0.0] for o in gaps]
    both = [
        (o.shrinkage, o.attainable)
        for o in gaps
        if o.claimed and o.shrinkage is not None and o.attainable is not None
    ]
    return {
        "removed_percent": bootstrapped(median, removed),
        "removed_of_all_percent": bootstrapped(median, of_all),
        "shrinkage_error_percent": bootstrapped(
            lambda a: float(np.median(np.abs(a[:, 0] - a[:, 1]))), both
        ),
    }


def _by_mechanism(outcomes: Sequence[Outcome]) -> dict[str, dict[str, Any]]:
    """Accuracy on visible single effects, and the number of faint ones, by cause."""
    single = [o for o in outcomes if o.kind == "single"]
    table = {}
    for name in sorted({o.cause[0] for o in single}):
        cases = [o for o in single if o.cause == (name,)]
        seen = [o for o in cases if o.visible]
        table[name] = {
            "top1": proportion([o.right for o in seen]),
            "top2": proportion([o.right_in_two for o in seen]),
            "faint": len(cases) - len(seen),
        }
    return table


def _parameter_errors(outcomes: Sequence[Outcome]) -> dict[str, Estimate]:
    """Median relative error of every parameter both sides name alike, in rightly named cases."""
    errors: dict[str, list[list[float]]] = {}
    for o in outcomes:
        for effect, name, true, estimated in o.parameters:
            size = abs(estimated - true) / max(abs(true), 1e-12)
            errors.setdefault(f"{effect} {name}", []).append([size])
    return {key: bootstrapped(median, rows) for key, rows in sorted(errors.items())}
