"""How much a motion would tell two hypotheses apart, the wrong one refitted.

With hypothesis A true and B fitted to old and new runs together, the log likelihood ratio has the
mean (T-optimality: Atkinson and Fedorov 1975, Biometrika 62, 57, eq. 2.4; here for dynamic models)

    D = min over b of [ |r_B(b)|^2 + |J_old (b - b_old)|^2 ] / (2 sigma^2 c)  [nats],

r_B the prediction errors of B on the noise-free run that A would give, J_old the Jacobian of B on
the existing runs, sigma the noise and c the samples one independent sample is worth. The ratio has
the variance 2 D, so one run picks the wrong one with the probability Phi(-sqrt(D/2)).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import lsq_linear

from ....models.fourier_motion import FourierMotion
from ..fitting import effective_samples
from ..hypothesis import Fit
from ..machine import Array, RunData
from ..prediction import Predictor
from .limits import drive_of

STEP = 1e-4  # of finite differences, in parameter scales


@dataclass(frozen=True, kw_only=True)
class Response:
    """What one hypothesis would give on a motion, and what the other would say to it."""

    nats: float  # expected log likelihood ratio of one run
    difference: Array  # (samples, n) prediction errors of the refitted other [position unit]
    effort: float  # largest command of any shaft
    run: RunData  # the noise-free run


class Side:
    """A fitted hypothesis: simulates a motion when true, and is refitted when it is not."""

    def __init__(self, predictor: Predictor, fit: Fit, noise: float) -> None:
        self._predictor, self.fit, self._noise = predictor, fit, noise
        self._machine = drive_of(predictor.machine)
        free = fit.hypothesis.free(predictor.machine)
        self._keys = tuple((effect, p.name) for effect, p in free)
        parameters = [p for _, p in free]
        self._scale = np.array([p.scale for p in parameters])
        known = fit.by_key()
        self._x = np.array([known[key] for key in self._keys]) / self._scale
        self._lower = np.array([p.lower for p in parameters]) / self._scale
        self._upper = np.array([p.upper for p in parameters]) / self._scale
        self._step = max([STEP, *(form.step for form in fit.hypothesis.forms)])
        residual, jacobian = self._linearised(predictor.runs)
        columns = residual.reshape(-1, len(predictor.machine.joints))
        self.worth = residual.size / effective_samples(columns)  # c, samples per independent one
        self._known = jacobian.T @ jacobian

    def plays(self, run: RunData) -> RunData:
        """The noise-free run this hypothesis gives on a run's reference and controller."""
        plant = self.fit.hypothesis.plant(self._predictor.machine, self.fit.by_key(), run.start)
        position, command = self._machine.simulate(replace(run, lsb=0.0), plant)
        return replace(run, position=position, command=command, window=slice(None))

    def answers(self, run: RunData) -> tuple[float, Array]:
        """Least sum of squares (new and old, over 2 sigma^2) this hypothesis can reach, and errors.

        The refit is one linear step inside the bounds; the errors are predicted in full there.
        """
        residual, jacobian = self._linearised([run])
        hessian = jacobian.T @ jacobian + self._known
        step = np.zeros(self._x.size)
        if self._x.size:
            size = np.sqrt(np.diag(hessian)) + 1e-300
            normal = hessian / np.outer(size, size) + 1e-9 * np.eye(self._x.size)
            root = np.linalg.cholesky(normal)
            target = -np.linalg.solve(root, jacobian.T @ residual / size)
            low, high = (self._lower - self._x) * size, (self._upper - self._x) * size
            margin = 1e-9 * (1.0 + np.abs(high))
            step = lsq_linear(
                root.T, target, (np.minimum(low, -margin), np.maximum(high, margin))
            ).x
            step = np.clip(step / size, self._lower - self._x, self._upper - self._x)
        refitted = self._errors([self._x + step], [run])[0]
        costs = [
            (float(np.sum(r**2) + s @ self._known @ s), r)
            for r, s in ((refitted, step), (residual.reshape(refitted.shape), 0.0 * step))
        ]
        cost, best = min(costs, key=lambda c: c[0])
        return cost / (2.0 * self._noise**2), best

    def _linearised(self, runs: list[RunData]) -> tuple[Array, Array]:
        """All prediction errors of the runs, and their derivatives by the scaled parameters."""
        steps = np.where(self._x + self._step > self._upper, -self._step, self._step)
        points = [self._x, *(self._x + np.diag(steps))]
        flat = [r.ravel() for r in self._errors(points, runs)]
        columns = [(moved - flat[0]) / step for moved, step in zip(flat[1:], steps)]
        return flat[0], np.column_stack(columns) if columns else np.zeros((flat[0].size, 0))

    def _errors(self, points: list[Array], runs: list[RunData]) -> list[Array]:
        scaled = [self._scale * x for x in points]
        found = self._predictor.residuals(self.fit.hypothesis, scaled, self._keys, runs)
        return [np.concatenate(row) for row in found]


class Contest:
    """Two sides and everything a motion is judged with."""

    def __init__(self, predictor: Predictor, fits: tuple[Fit, Fit], noise: float) -> None:
        self.noise = noise
        self.sides = tuple(Side(predictor, fit, noise) for fit in fits)
        self.worth = max(side.worth for side in self.sides)
        self.simulations = 0  # closed-loop ones; predictions are counted by the predictor

    def responses(self, template: RunData) -> list[Response] | None:
        """Both responses to the template's reference; None where a closed loop diverges."""
        found = []
        for true, other in (self.sides, self.sides[::-1]):
            run = true.plays(template)
            self.simulations += 1
            reach = 10.0 * (np.max(np.abs(run.reference)) + 1.0)
            if not np.all(np.abs(run.position) < reach) or not np.all(np.isfinite(run.command)):
                return None
            cost, errors = other.answers(run)
            found.append(
                Response(
                    nats=cost / self.worth,
                    difference=errors,
                    effort=float(np.max(np.abs(run.command))),
                    run=run,
                )
            )
        return found


def template(motion: FourierMotion, like: RunData, start: float) -> RunData:
    """A run of the motion under the controller of ``like``, nothing measured yet."""
    t = motion.times(like.dt)
    reference, rate, acceleration = (np.ascontiguousarray(a) for a in motion.sample(t))
    return replace(
        like,
        name=motion.name,
        use="fit",
        settings={"period_s": motion.period},
        t=t,
        reference=reference,
        reference_rate=rate,
        reference_acceleration=acceleration,
        position=reference.copy(),
        command=np.zeros_like(reference),
        period=round(motion.period / like.dt),
        start=start,
        window=slice(None),
    )
