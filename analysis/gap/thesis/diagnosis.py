"""The diagnosis of the thesis's own gap, from printed tables to verdict.

Fitted and chosen on the 2 Hz experiment (Table 5-4), checked on the 1 Hz experiment (Table 5-9). A
hypothesis that predicts the held-out table worse than the retuned nominal model is refuted, however
well it does at 2 Hz; its probability then goes to ``unknown``.
"""

import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.metadata import version

import numpy as np

from ....models.c_drive import CDriveParameters
from ..hypothesis import Fit, Hypothesis
from ..machines.c_drive import c_drive_machine
from ..ranking import Ranked
from ..verdict import Verdict, decide
from .candidates import CANDIDATES, candidate_forms
from .carry_over import carry_over, parameter_intervals
from .evidence import observations
from .experiment import (
    read_experiment,
    replicate_differences,
    scatter,
)
from .findings import entries, location, next_experiment, variants, warnings
from .fitting import TableFitter
from .identifiability import identifiability
from .loops import BenchmarkLoops
from .result import ThesisDiagnosis
from .selection import select

SOURCE = "Friedlaender 2015, Tables 5-4 (2 Hz, fitted) and 5-9 (1 Hz, held out)"
TOLERANCE = 0.03  # of the nominal parameters
MOST_LOSS = 0.1  # rise of the log held-out error from which on a hypothesis is refuted

Progress = Callable[[str], None]


def diagnose_thesis(
    *,
    seed: int = 0,
    progress: Progress | None = None,
    candidates: Sequence[str] = CANDIDATES,
) -> ThesisDiagnosis:
    """Diagnose the printed experiment; half a minute with all candidates.

    ``progress`` is told a few words at each step; ``candidates`` are the effect ids to try.
    """
    started = time.perf_counter()
    tell = progress or (lambda text: None)
    machine = c_drive_machine(CDriveParameters(), TOLERANCE)
    tables = {rate: read_experiment(rate) for rate in (2.0, 1.0)}
    spread = scatter(tables[2.0])
    fitter, held_out = (
        TableFitter(machine, BenchmarkLoops(rate), tables[rate], spread) for rate in (2.0, 1.0)
    )
    tell("retuning the nominal model")
    nominal, retuned = nominal_fit(fitter), fitter.fit(Hypothesis())
    forms = candidate_forms(machine, tables[2.0], candidates)
    ranking = select(fitter, retuned, forms, seed, tell)
    tell("checking on the 1 Hz table")
    errors = [float(np.sqrt(np.mean(held_out.errors(r.fit) ** 2))) for r in ranking]
    limit = errors[_of_retuned(ranking)] * float(np.exp(MOST_LOSS))
    refuted = [bool(r.fit.hypothesis.forms) and e > limit for r, e in zip(ranking, errors)]
    verdict = _checked(ranking, errors, refuted, spread.relative)
    chosen = verdict.accepted.fit if verdict.accepted else retuned
    best = ranking[0].fit
    shrinkage = carry_over(fitter, held_out, nominal, retuned, chosen, seed)
    found = [o for table in tables.values() for o in observations(table, spread)]
    tell("asking what the table can tell apart")
    seen = identifiability(fitter, retuned, forms, spread.relative)
    return ThesisDiagnosis(
        verdict=verdict,
        ranking=tuple(ranking),
        held_out_errors=tuple(errors),
        refuted=tuple(refuted),
        scatter=spread,
        replicate={
            f"{rate:g} Hz": [float(d) for d in replicate_differences(table)]
            for rate, table in tables.items()
        },
        best=best,
        best_carry_over=shrinkage
        if best is chosen
        else carry_over(fitter, held_out, nominal, retuned, best, seed),
        intervals=parameter_intervals(fitter, best, seed),
        shrinkage=shrinkage,
        entries=entries((fitter, held_out), nominal, retuned, best, spread),
        location=location(fitter.errors(retuned)),
        observations=tuple(found),
        identifiability=seen,
        variants=variants(tables, spread, fitter, held_out, nominal),
        next_experiment=next_experiment(machine, ranking, spread),
        warnings=tuple(warnings(best, tables, spread, found)),
        provenance={
            "gapscope": version("gapscope"),
            "python": platform.python_version(),
            "numpy": np.__version__,
            "source": SOURCE,
            "seed": seed,
            "simulated_tests": fitter.loops.simulations + held_out.loops.simulations,
            "seconds": time.perf_counter() - started,
        },
    )


def nominal_fit(fitter: TableFitter) -> Fit:
    """The nominal model as it stands, as a fit without free parameters."""
    own = tuple(replace(p, lower=p.starts[0], upper=p.starts[0]) for p in fitter.machine.own)
    frozen = replace(fitter.machine, own=own)
    empty = TableFitter(frozen, fitter.loops, fitter.experiment, fitter.scatter).fit(Hypothesis())
    return replace(
        empty,
        keys=fitter.problem(Hypothesis()).keys,
        values=np.array([p.starts[0] for p in fitter.machine.own]),
        deviation=np.zeros(len(own)),
    )


def _of_retuned(ranking: Sequence[Ranked]) -> int:
    return next(i for i, r in enumerate(ranking) if not r.fit.hypothesis.forms)


def _checked(
    ranking: Sequence[Ranked], errors: Sequence[float], refuted: Sequence[bool], floor: float
) -> Verdict:
    """Verdict on the fitted table, withdrawn where the held-out table contradicts it."""
    retuned = _of_retuned(ranking)
    verdict = decide(ranking, ranking[retuned], floor)
    best = verdict.accepted or ranking[0]
    place = next(i for i, r in enumerate(ranking) if r is best)
    if not refuted[place]:
        return verdict
    reason = (
        f"{verdict.reason} It also fails the check: fitted at 2 Hz, it predicts the 1 Hz table with a "
        f"relative error of {100 * errors[place]:.0f} %, against {100 * errors[retuned]:.0f} % of the "
        "retuned nominal model."
    )
    return replace(verdict, verdict="unexplained", reason=reason, accepted=None)
