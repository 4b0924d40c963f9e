"""Search without derivatives for the parameters of impacts: evolution of a population (CMA-ES).

A population is predicted at once, which costs a fraction of as many predictions one after the other, and sees beyond
the roughness of impacts. Hansen, *The CMA Evolution Strategy: A Tutorial*, arXiv:1604.00772.
"""

from collections.abc import Callable

import numpy as np

from .machine import Array
from .prediction import Problem, flatten

POPULATION = 16
GENERATIONS = 60  # of a whole search
FIRST_GENERATIONS = 10  # of one that is only taken further where it leads somewhere
LEVEL = 1e-3  # a search ends when the best losses of the last generations differ by less, of all it gained
SEED = 1
PART = 0.15  # of a parameter's size, or of LEAST scales: spread of the first generation
LEAST = 0.2
OWN_PART = 2e-3  # of the scale of a machine's own parameter, which is known well


def evolve(problem: Problem, start: Array, cost: float, generations: int) -> Array:
    """Best point that evolution finds from ``start``, whose loss is ``cost``."""
    import cma  # takes a third of a second

    spread = np.where(problem.of_effects, PART * np.maximum(np.abs(start), LEAST), OWN_PART)
    lower, upper = problem.lower / spread, problem.upper / spread
    strategy = cma.CMAEvolutionStrategy(
        np.clip(start / spread, lower, upper),
        1.0,
        {
            "popsize": POPULATION,
            "bounds": [lower, upper],
            "maxiter": generations,
            "tolfunrel": LEVEL,
            "randn": _normal(np.random.default_rng(SEED)),
            "seed": np.nan,  # numpy's own generator belongs to the user
            "verbose": -9,
        },
    )
    best = start
    while not strategy.stop():
        asked = strategy.ask()
        points = [np.clip(np.asarray(x) * spread, problem.lower, problem.upper) for x in asked]
        costs = [float(np.sum(flatten(r) ** 2)) for r in problem.runs(points)]
        strategy.tell(asked, costs)
        i = int(np.argmin(costs))
        if costs[i] < cost:
            best, cost = points[i], costs[i]
    return best


def _normal(random: np.random.Generator) -> Callable[..., Array]:
    """Standard normal numbers, as ``numpy.random.randn`` gives them."""
    return lambda *shape: random.standard_normal(shape)
