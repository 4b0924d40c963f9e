"""``flaws.md``: which withheld flaws of the PepperMill-Carrier were named, place by place."""

from collections.abc import Mapping, Sequence
from typing import Any

from ..blind_statistics import proportion
from .flaws import REPORTED_FROM

Outcomes = Sequence[Mapping[str, Any]]


def markdown(outcomes: Outcomes) -> str:
    """Counts with Wilson intervals, and a table with one row for each flaw and seed."""
    lines = [
        "# Flaws of a PepperMill-Carrier that the diagnosis was not told",
        "",
        *(f"- {line}" for line in summary(outcomes)),
        "",
        "A seed draws the robot's masses and friction within 1 % of what the diagnosis believes; kinds and sizes of the "
        "flaws are always the same, so that a further seed is no further kind. Shares have 95 % Wilson intervals as if logs "
        "were drawn alike. Torques are rms of what is unexplained on the validation run; the floor is the encoders'.",
        "",
        "| flaw | seed | truth | verdict | best hypothesis | places | before [N m] | after | floor | gap removed |",
        "|---" * 10 + "|",
    ]
    lines += [_row(o) for o in sorted(outcomes, key=lambda o: o["seed"])]
    return "\n".join(lines) + "\n"


def summary(outcomes: Outcomes) -> list[str]:
    """What was tried, and how much of it was right."""
    seeds = sorted({o["seed"] for o in outcomes})
    return [
        f"{len(outcomes)} logs, {_seeds(seeds)}. {_tuned(seeds)}",
        f"right: {_share([o['right'] for o in outcomes])}",
        f"confident and wrong: {_share([o['wrong'] for o in outcomes])}",
        f"places right: {_share([o['placed'] for o in outcomes if o['placed'] is not None])}",
    ]


def cells(o: Mapping[str, Any]) -> tuple[str, ...]:
    """Flaw, seed, verdict, best hypothesis and gap removed of one outcome in words."""
    mark = "" if o["right"] else (" - wrong" if o["wrong"] else " - abstains")
    top = f"{' + '.join(o['top']) or 'nominal'} ({o['probability']:.3f})"
    return o["flaw"], str(o["seed"]), o["verdict"] + mark, top, _removed(o)


def _row(o: Mapping[str, Any]) -> str:
    flaw, seed, verdict, top, removed = cells(o)
    truth = " ".join(filter(None, (o["effect"] or "nothing", ", ".join(o["where"]))))
    return (
        f"| {flaw} | {seed} | {truth} | {verdict} | {top} | {', '.join(o['places']) or '-'} "
        f"| {o['before']:.3g} | {o['after']:.3g} | {o['floor']:.3g} | {removed} |"
    )


def _removed(o: Mapping[str, Any]) -> str:
    if o["percent"] is None:
        return "-"
    interval = f" ({o['ci95'][0]:.0f} to {o['ci95'][1]:.0f})" if o["ci95"] else ""
    return f"{o['percent']:.0f} %{interval}"


def _share(hits: Sequence[bool]) -> str:
    found = proportion(hits)
    if not hits:
        return "none asked"
    return f"{sum(hits)} of {found.n} ({100 * found.low:.0f} to {100 * found.high:.0f} %)"


def _seeds(seeds: Sequence[int]) -> str:
    return ("seed " if len(seeds) == 1 else "seeds ") + ", ".join(map(str, seeds))


def _tuned(seeds: Sequence[int]) -> str:
    if seeds[0] >= REPORTED_FROM:
        return "No log of these seeds was looked at while the instrument was mended."
    return f"Seeds below {REPORTED_FROM} were looked at while the instrument was mended: no proof."
