r"""Gradient search for exciting motions: sequential quadratic programming (SNOPT, through Drake) from many starts.

The limits are linear constraints at the instants of a cycle. With eigenvectors u of :math:`W^T W` for its largest and
smallest eigenvalue, :math:`d \log \kappa = (Wu)^T (dW\,u)/\lambda` of the largest less that of the smallest; dW by
position, rate and acceleration of each instant is a central difference. The sign of dry friction is smoothed in the search,
and exact in the condition number that is reported.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .excitation import MARGIN, SAMPLES, Excitation, Objective, of

Floats = NDArray[np.float64]

SOFT = 0.02  # of the largest speed, over which the sign of friction is smoothed
STEP = 1e-6  # of central differences, in limits
ITERATIONS = 100  # of one start
TRIALS = 50  # random motions, of which the best is a start
AT_RANDOM = 4  # local searches from random motions
KICK = 0.3  # of the amplitudes' size, by which the best motion is disturbed


def search(objective: Objective, budget: int, seed: int) -> Excitation:
    """Best motion of as many local searches as the budget of evaluations allows, one at least.

    Some begin at random, the others at the best motion so far, disturbed: its neighbours are better than random ones.
    """
    problem, rng = Problem(objective), np.random.default_rng(seed)
    best, at, least, rounds = None, np.zeros(0), np.inf, 0
    while best is None or objective.evaluations < budget:
        start = problem.start(rng) if rounds < AT_RANDOM else problem.disturbed(at, rng)
        z, rounds = problem.solve(start, budget), rounds + 1
        motion = objective.moving(*problem.split(z))
        found = of(objective.machine, tuple(objective.kept), motion)
        if best is None or found < least:
            best, at, least = motion, z, found
    return best


class Problem:
    """Value, slope and limits over vectors (n + n terms,): starts in shares of the travel, amplitudes in speed limits."""

    def __init__(self, objective: Objective) -> None:
        self.objective, self.machine = objective, objective.machine
        m, n, terms = self.machine, self.machine.axes, objective.terms
        self.size = n * (1 + terms)
        self.basis = [
            m.speed[:, None, None] * part for part in objective.basis
        ]  # (n, times, terms)
        self.span = m.upper - m.lower
        self.rows, self.low, self.high = self._limits(n, terms)

    def split(self, z: Floats) -> tuple[Floats, Floats]:
        """Start (n,) and amplitudes (n, terms) as ``Objective`` takes them."""
        n = self.machine.axes
        rest = z[n:].reshape(n, -1) * self.machine.speed[:, None]
        return self.machine.lower + self.span * z[:n], rest

    def start(self, rng: np.random.Generator) -> Floats:
        """The best of some random motions, drawn into the limits."""
        n, trials = self.machine.axes, []
        for _ in range(TRIALS):
            z = np.concatenate([rng.uniform(0.2, 0.8, n), 0.3 * rng.normal(size=self.size - n)])
            z = self._drawn(z)
            trials.append((self.value(z)[0], tuple(z)))
        return np.array(min(trials)[1])

    def disturbed(self, z: Floats, rng: np.random.Generator) -> Floats:
        """Another motion near this one."""
        n = self.machine.axes
        size = np.concatenate([np.full(n, 0.1), np.full(z.size - n, KICK * z[n:].std())])
        moved = z + size * rng.normal(size=z.size)
        moved[:n] = np.clip(moved[:n], 0.1, 0.9)
        return self._drawn(moved)

    def _drawn(self, z: Floats) -> Floats:
        """The motion with its amplitudes reduced until it keeps the limits."""
        n = self.machine.axes
        still = self.rows[:, :n] @ z[:n]
        moving = self.rows[:, n:] @ z[n:]
        beyond = np.maximum(moving / (self.high - still), moving / (self.low - still))
        return np.concatenate([z[:n], z[n:] / max(1.0, float(beyond.max()))])

    def value(self, z: Floats) -> tuple[float, Floats]:
        """log10 of the condition number, and its slope (size,)."""
        n = self.machine.axes
        q, v, a = self._motion(z)
        steps = np.concatenate(
            [STEP * self.span, STEP * self.machine.speed, STEP * self.machine.acceleration]
        )
        moves = (np.eye(3 * n) * steps).reshape(3 * n, 3, n)
        both = np.concatenate([np.zeros((1, 3, n)), moves, -moves])[:, :, None, :]
        w = self._regressor(q + both[:, 0], v + both[:, 1], a + both[:, 2])
        self.objective.evaluations += len(both)
        if not np.isfinite(w).all():
            return 10.0, np.zeros(self.size)
        here = w[0].reshape(-1, w.shape[-1])
        values, vectors = np.linalg.eigh(here.T @ here)
        if values[0] <= 0.0:
            return 10.0, np.zeros(self.size)
        by = (w[1 : 3 * n + 1] - w[3 * n + 1 :]) / (2.0 * steps[:, None, None, None])
        slope = np.zeros((3 * n, q.shape[0]))
        for k, sign in ((-1, 1.0), (0, -1.0)):
            u = vectors[:, k]
            slope += sign / values[k] * np.einsum("ti,dti->dt", w[0] @ u, by @ u)
        return 0.5 * float(np.log10(values[-1] / values[0])), self._chain(slope) / np.log(10.0)

    def solve(self, start: Floats, budget: int) -> Floats:
        """A local minimum inside the limits."""
        from pydrake.autodiffutils import ExtractGradient, ExtractValue, InitializeAutoDiff
        from pydrake.solvers import MathematicalProgram, SnoptSolver

        program, solver = MathematicalProgram(), SnoptSolver()
        x = program.NewContinuousVariables(self.size)
        program.AddLinearConstraint(self.rows, self.low, self.high, x)

        def lifted(law: Any) -> Any:
            def of_type(z: Any) -> Any:
                plain = z.dtype == float
                at = z if plain else ExtractValue(z.reshape(-1, 1)).ravel()
                value, slope = law(at)
                if plain:
                    return value
                slope = np.atleast_2d(slope) @ ExtractGradient(z.reshape(-1, 1))
                out = InitializeAutoDiff(np.atleast_1d(value), slope).ravel()
                return out if np.ndim(value) else out[0]

            return of_type

        program.AddCost(lifted(self.value), vars=x)
        if self.objective.depth is not None:
            room = np.zeros(SAMPLES)
            program.AddConstraint(lifted(self.depth), room, np.full(SAMPLES, np.inf), vars=x)
        each = 1 + 6 * self.machine.axes
        left = max(10, min(ITERATIONS, (budget - self.objective.evaluations) // each))
        for name, value in (("Major iterations limit", left), ("Major optimality tolerance", 1e-4)):
            program.SetSolverOption(solver.solver_id(), name, value)
        return np.asarray(solver.Solve(program, start).GetSolution(x))

    def depth(self, z: Floats) -> tuple[Floats, Floats]:
        """How far the joints are inside the polygon at each instant beyond its margin, in its size, and the slope."""
        assert self.objective.depth is not None
        q, n = self._motion(z)[0], self.machine.axes
        steps = np.diag(1e-4 * self.span)
        at = self.objective.depth(q)
        by = np.stack([
            (self.objective.depth(q + s) - self.objective.depth(q - s)) / (2.0 * s.sum()) for s in steps
        ])  # fmt: skip
        slope = np.zeros((len(at), self.size))
        slope[:, :n] = (by * self.span[:, None]).T
        slope[:, n:] = np.einsum("nt,ntk->tnk", by, self.basis[0]).reshape(len(at), -1)
        size = self.objective.polygon_size
        return np.asarray(at / size - MARGIN), slope / size

    def _motion(self, z: Floats) -> tuple[Floats, Floats, Floats]:
        n = self.machine.axes
        rest = z[n:].reshape(n, -1)
        q, v, a = (np.einsum("ntk,nk->tn", part, rest) for part in self.basis)
        return self.machine.lower + self.span * z[:n] + q, v, a

    def _regressor(self, q: Floats, v: Floats, a: Floats) -> Floats:
        """As ``Machine.full_regressor``, with a smooth sign, on the kept columns."""
        axis = np.eye(self.machine.axes)
        smooth = np.tanh(v / (SOFT * self.machine.speed))
        friction = [smooth[..., None] * axis, v[..., None] * axis]
        full = np.concatenate([self.machine.rigid(q, v, a), *friction], axis=-1)
        return full[..., self.objective.kept]

    def _chain(self, slope: Floats) -> Floats:
        """Slope by starts and amplitudes of the slope (3n, times) by positions, rates and accelerations."""
        n = self.machine.axes
        parts = slope.reshape(3, n, -1)
        by_start = parts[0].sum(axis=-1) * self.span
        by_shape = sum(np.einsum("nt,ntk->nk", p, b) for p, b in zip(parts, self.basis))
        return np.concatenate([by_start, np.ravel(by_shape)])

    def _limits(self, n: int, terms: int) -> tuple[Floats, Floats, Floats]:
        """Rows and bounds of position, rate and acceleration at each instant, in limits."""
        m, room, rows, low, high = self.machine, 1.0 - MARGIN, [], [], []
        for j in range(n):
            for order, (below, above) in enumerate((
                (m.lower[j], m.upper[j]), (-m.speed[j], m.speed[j]), (-m.acceleration[j], m.acceleration[j]),
            )):  # fmt: skip
                half, part = 0.5 * (above - below), np.zeros((SAMPLES, self.size))
                part[:, n + j * terms : n + (j + 1) * terms] = self.basis[order][j] / half
                if order == 0:
                    part[:, j] = self.span[j] / half
                middle = 0.0 if order else -(m.lower[j] - 0.5 * (below + above)) / half
                rows.append(part)
                low.append(np.full(SAMPLES, middle - room))
                high.append(np.full(SAMPLES, middle + room))
        return np.vstack(rows), np.concatenate(low), np.concatenate(high)
