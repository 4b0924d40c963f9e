r"""What may still be claimed where the model's law is itself only an approximation.

1. nearness    :math:`r \le 1.3\,f`, with the floor f of a machine that counts its law's error in
2. rivals      :math:`r_o^2 - r^2 < \epsilon^2` of a hypothesis with no more effects and parameters
3. further     :math:`r_s^2 - r^2 < \phi^2 (r_0^2 - r_s^2)` of a hypothesis s with fewer effects: what more add to it

r are held-out residuals, r_0 that of the retuned model, :math:`\epsilon` the law's own error and
:math:`\phi` by how much the form of an effect misses the effect, as a share of what it removes. An explanation that
fails (1) is none. Those that meet (2) or (3) are not told apart: the law's error imitates the difference.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from .attribution import Ranked
from .verdict import NEAR_FLOOR, Verdict


@dataclass(frozen=True, kw_only=True)
class LawError:
    """How far a law and the forms of its effects are from the machine."""

    law: float  # rms of the residual that the law leaves without any effect [residual unit]
    form: float  # rms that the form of an effect leaves, over the rms that it removes [-]


def within_law(
    verdict: Verdict,
    ranking: Sequence[Ranked],
    retuned: Ranked,
    floor: float,
    error: LawError | None,
) -> Verdict:
    """The verdict, or ``unexplained`` by (1), or ``ambiguous`` by (2) and (3); as it is without an ``error``.

    ``floor`` in the unit of the held-out residuals.
    """
    best = verdict.accepted
    if error is None or best is None:
        return verdict
    left = best.fit.held_out_rms / floor
    if left > NEAR_FLOOR:
        return replace(
            verdict,
            verdict="unexplained",
            reason=f"{best.fit.hypothesis.label} explains most of the gap but leaves {left:.1f} x the floor, in which "
            f"the error of the law is counted; {NEAR_FLOOR} x at most are asked. Something else acts as well, or instead.",
            accepted=None,
            rivals=(),
        )
    found = [r for r in ranking if r is not best and _imitated(r, best, retuned, error)]
    rivals = (*verdict.rivals, *(r for r in found if r not in verdict.rivals))
    if not found:
        return verdict
    names = " and ".join(r.fit.hypothesis.label for r in (best, *rivals))
    return replace(
        verdict,
        verdict="ambiguous",
        reason=f"What separates {names} is no larger than the error of the law, or of an effect's form.",
        rivals=rivals,
    )


def _imitated(other: Ranked, best: Ranked, retuned: Ranked, error: LawError) -> bool:
    """Whether errors of the law can make the best better than the other: (2) or (3)."""
    mine, its = set(best.fit.hypothesis.ids), set(other.fit.hypothesis.ids)
    if not its or mine <= its:
        return False
    simpler = len(its) <= len(mine) and other.fit.hypothesis.size <= best.fit.hypothesis.size
    worse = other.fit.held_out_rms**2 - best.fit.held_out_rms**2
    removed = retuned.fit.held_out_rms**2 - other.fit.held_out_rms**2
    by_law = simpler and worse < error.law**2
    return by_law or (len(its) < len(mine) and worse < error.form**2 * removed)
