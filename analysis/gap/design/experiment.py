"""Search for the motion that best separates the top two hypotheses of a diagnosis.

Outside, scipy's differential evolution over the coefficients of a Fourier series; inside, every
candidate is simulated as if either hypothesis were true, and the other refitted by one linear step
(``discrepancy``). What is maximised is the smaller of the two expected log likelihood ratios. The
motion that wins is judged once more with the full fits of the diagnosis.
"""

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import Bounds, differential_evolution
from scipy.stats import norm
from threadpoolctl import threadpool_limits

from ....models.fourier_motion import FourierMotion
from ...errors import InputError
from ...files import write_folder
from ..fitting import fit
from ..hypothesis import Fit
from ..machine import Array, RunData
from ..prediction import Predictor
from ..result import Diagnosis
from .discrepancy import Contest, Response, template
from .limits import Limits, drive_of, limits_of
from .motions import Motions, scaled
from .pair import Pair, top_two

PERIOD = 1.0  # of a cycle [s]
CYCLES = 3  # the instrument leaves the first out of the noise floor
CANDIDATES = 600  # motions looked at
MARGIN = 0.98  # of the effort limit, for the machine's difference from both hypotheses
ERROR = 0.01  # probability of the wrong choice that the number of runs is stated for

Progress = Callable[[str], None]


@dataclass(frozen=True, kw_only=True)
class Design:
    """A designed motion and what it is expected to tell."""

    diagnosis: Diagnosis
    pair: Pair
    limits: Limits
    controller: str
    motion: FourierMotion
    responses: tuple[Response, ...]  # if the first hypothesis is true, if the second is
    noise: float  # rms [position unit]
    nats: float  # expected of one run by full refits, the smaller of both directions
    before: float  # what the existing fit runs say for the first hypothesis, in sample [nats]
    repeat: dict[str, Any]  # the best logged motion: its run and the nats of repeating it
    error: float  # probability of the wrong choice that ``runs`` is for
    simulations: int
    candidates: int
    seconds: float
    seed: int

    @property
    def runs(self) -> int:
        """Runs needed for the stated error probability."""
        return runs_needed(self.nats, self.error)

    def to_json(self) -> dict[str, Any]:
        """``design.json``."""
        machine = drive_of(self.diagnosis.machine)
        _, rate, _ = self.motion.sample(np.linspace(0.0, self.motion.period, 1000))
        rms = [float(np.sqrt(np.mean(r.difference**2))) for r in self.responses]
        return {
            "logset": self.diagnosis.logset.name,
            "verdict": self.diagnosis.verdict.verdict,
            "separates": [list(self.pair.first.fit.hypothesis.ids),
                          list(self.pair.second.fit.hypothesis.ids)],
            "remark": self.pair.remark,
            "motion": "motion.yaml",
            "controller": self.controller,
            "limits": self.limits.to_json(machine.task),
            "units": {"position": machine.position_unit, "effort": machine.effort_unit},
            "largest_speed": float(np.max(np.abs(rate))),
            "largest_effort": max(r.effort for r in self.responses),
            "noise_rms": self.noise,
            "difference_rms": {"first_true": rms[0], "second_true": rms[1]},
            "expected_nats": {
                "existing_runs": self.before,
                "repeating_the_best_logged_motion": self.repeat,
                "designed_motion": self.nats,
            },
            "z": float(np.sqrt(2.0 * max(self.nats, 0.0))),
            "runs_needed": {"error_probability": self.error, "runs": self.runs},
            "provenance": {
                "seed": self.seed,
                "candidates": self.candidates,
                "simulations": self.simulations,
                "seconds": self.seconds,
            },
        }  # fmt: skip

    def save(self, out: Path) -> list[Path]:
        """Write ``design.json``, ``motion.yaml`` and ``design.png``, all or none."""
        from .figure import plot_design

        text = json.dumps(self.to_json(), indent=1, allow_nan=False)
        return write_folder(
            out,
            {
                "design.json": lambda path: path.write_text(text, encoding="utf-8"),
                "motion.yaml": self.motion.save,
                "design.png": lambda path: plot_design(self, path),
            },
        )


def runs_needed(nats: float, error: float) -> int:
    """Runs after which the wrong hypothesis leads with at most the probability ``error``.

    The log likelihood ratio of n runs has mean n D and variance 2 n D: n = 2 z^2 / D.
    """
    z = float(norm.isf(error))
    return max(1, int(np.ceil(2.0 * z * z / max(nats, 1e-9) - 1e-9)))


def design_experiment(
    diagnosis: Diagnosis,
    *,
    limits: Limits | None = None,
    controller: str | None = None,
    period: float = PERIOD,
    candidates: int = CANDIDATES,
    error: float = ERROR,
    seed: int = 0,
    progress: Progress | None = None,
) -> Design:
    """The motion that best separates the top two hypotheses of a diagnosis.

    ``controller`` is an id of the log set, by default that of its first fit run; ``period`` is of one
    cycle [s]. Raises InputError where there is nothing to separate, for an unknown controller, and
    where no candidate could be simulated.
    """
    started = time.perf_counter()
    tell = progress or (lambda text: None)
    pair = top_two(diagnosis)
    bounds = limits or limits_of(diagnosis)
    like, name = _under(diagnosis, controller)
    if not period >= 100 * like.dt:
        raise InputError("period", f"{period:g} s", f"at least {100 * like.dt:g} s, 100 samples")
    fits = (pair.first.fit, pair.second.fit)
    with threadpool_limits(1):
        predictor = Predictor(diagnosis.machine, [r for r in diagnosis.runs if r.use == "fit"])
        noise = max(diagnosis.floor, min(f.rms for f in fits))
        contest = Contest(predictor, fits, noise)
        start = max(run.start + len(run.t) * run.dt for run in diagnosis.runs)
        search = _Search(
            contest, Motions(drive_of(diagnosis.machine), bounds, period), bounds, like, start
        )
        tell("searching for a motion")
        motion = search.best(candidates, seed, tell)
        responses = contest.responses(template(motion, like, start))
        if responses is None:
            raise InputError("controller", "the loop diverges on every motion", "a stable loop")
        tell("judging it by full fits")
        nats = min(
            _refitted(predictor, other, r.run, noise) / contest.worth
            for other, r in zip(fits[::-1], responses)
        )
        return Design(
            diagnosis=diagnosis,
            pair=pair,
            limits=bounds,
            controller=name,
            motion=motion,
            responses=tuple(responses),
            noise=noise,
            nats=min(nats, *(r.nats for r in responses)),
            before=_said(predictor, fits, noise) / contest.worth,
            repeat=_repeated(contest, predictor.runs, start),
            error=error,
            simulations=predictor.simulations + contest.simulations,
            candidates=search.seen,
            seconds=time.perf_counter() - started,
            seed=seed,
        )


class _Search:
    """Differential evolution over one cycle of a motion."""

    def __init__(
        self, contest: Contest, motions: Motions, limits: Limits, like: RunData, start: float
    ) -> None:
        self._contest, self._motions, self._limits = contest, motions, limits
        self._like, self._start = like, start
        self.seen = 0

    def best(self, candidates: int, seed: int, tell: Progress) -> FourierMotion:
        """The best of about so many candidates, shrunk until the effort limit holds."""
        size = self._motions.size
        members = max(5, min(2 * size, candidates // 10))
        rng = np.random.default_rng(seed)
        found = differential_evolution(
            self._loss,
            Bounds(np.full(size, -1.0), np.full(size, 1.0)),
            init=rng.uniform(-1.0, 1.0, (members, size)),
            maxiter=max(1, candidates // members - 1),
            tol=0.0,
            polish=False,
            rng=rng,
            callback=lambda intermediate_result: tell(
                f"searching for a motion: {-intermediate_result.fun:.3g} nats a cycle"
            ),
        )
        motion = self._motions.motion(found.x, CYCLES)
        for _ in range(60):
            effort = self._effort(motion)
            if effort <= MARGIN * self._limits.effort:
                return motion
            motion = scaled(motion, max(0.8, min(0.98, MARGIN * self._limits.effort / effort)))
        raise InputError("limits", "no motion keeps the effort limit", "a larger effort limit")

    def _effort(self, motion: FourierMotion) -> float:
        responses = self._contest.responses(template(motion, self._like, self._start))
        return max(r.effort for r in responses) if responses else np.inf

    def _loss(self, point: Array) -> float:
        self.seen += 1
        motion = self._motions.motion(point, 1)
        responses = self._contest.responses(template(motion, self._like, self._start))
        if responses is None:
            return 0.0
        nats = min(r.nats for r in responses)
        excess = max(r.effort for r in responses) / (MARGIN * self._limits.effort)
        return -nats / max(1.0, excess) ** 4


def _under(diagnosis: Diagnosis, controller: str | None) -> tuple[RunData, str]:
    """A run under the controller, whose settings the new run takes over."""
    ids = {run.name: run.controller for run in diagnosis.logset.runs}
    runs = [run for run in diagnosis.runs if run.use == "fit"]
    wanted = controller or ids[runs[0].name]
    for run in diagnosis.runs:
        if ids[run.name] == wanted:
            return run, wanted
    raise InputError(
        "controller", f"no run under {wanted!r}", f"one of {', '.join(sorted(set(ids.values())))}"
    )


def _said(predictor: Predictor, fits: tuple[Fit, Fit], noise: float) -> float:
    """Log likelihood ratio of the first over the second on the existing runs, white residuals."""
    first, second = (_sum_of_squares(predictor, f) for f in fits)
    return (second - first) / (2.0 * noise**2)


def _sum_of_squares(predictor: Predictor, f: Fit) -> float:
    found = predictor.residuals(f.hypothesis, [f.values], f.keys)[0]
    return float(sum(np.sum(r**2) for r in found))


def _refitted(predictor: Predictor, other: Fit, run: RunData, noise: float) -> float:
    """As ``Side.answers`` by a full fit to old and new runs together."""
    joint = Predictor(predictor.machine, [*predictor.runs, run])
    refit = fit(joint, other.hypothesis, other)
    risen = _sum_of_squares(joint, refit) - _sum_of_squares(predictor, other)
    predictor.simulations += joint.simulations
    return max(risen, 0.0) / (2.0 * noise**2)


def _repeated(contest: Contest, runs: list[RunData], start: float) -> dict[str, Any]:
    """What repeating the most telling logged run would give."""
    best: dict[str, Any] = {"run": None, "nats": 0.0}
    for run in runs:
        responses = contest.responses(replace(run, start=start))
        nats = min(r.nats for r in responses) if responses else 0.0
        if nats > best["nats"]:
            best = {"run": run.name, "nats": nats}
    return best
