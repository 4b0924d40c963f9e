"""Starting points of a search for impacts."""

from types import SimpleNamespace

import numpy as np

from gapscope.analysis.gap.evolution import GENERATIONS, evolve
from gapscope.analysis.gap.machine import Parameter
from gapscope.analysis.gap.search import _starts


def parameter(name, starts, seconds=()):
    return Parameter(
        name=name, unit="-", lower=0.0, upper=10.0, scale=2.0, starts=starts, seconds=seconds
    )


def test_second_values_are_tried_from_the_best_starts():
    parameters = [parameter("gap", (1.0, 4.0, 8.0)), parameter("share", (5.0,), (3.0, 7.0))]
    best = np.array([4.0, 7.0])
    tried = []

    def runs(points):
        tried.extend(2.0 * x for x in points)
        return [[np.atleast_2d(2.0 * x - best)] for x in points]

    problem = SimpleNamespace(
        parameters=parameters,
        keys=tuple(("e", p.name) for p in parameters),
        scale=np.full(2, 2.0),
        lower=np.zeros(2),
        upper=np.full(2, 5.0),
        runs=runs,
    )
    (start,) = _starts(problem, None, together=True)
    np.testing.assert_array_equal(2.0 * start, best)
    assert len(tried) == 3 + 3 * 2
    known = SimpleNamespace(by_key=lambda: {("e", "share"): 5.0})
    (start,) = _starts(problem, known, together=True)
    np.testing.assert_array_equal(2.0 * start, [4.0, 5.0])


def ragged(x):
    """A valley with many small steps across it, as impacts make them: slopes say nothing of where it leads."""
    return np.array([x[0] - 3.0, 4.0 * (x[1] - 0.5 * x[0])]) + 0.05 * np.sign(np.sin(60.0 * x))


def test_evolution_crosses_what_is_too_rough_for_slopes():
    def runs(points):
        return [[np.atleast_2d(ragged(x))] for x in points]

    problem = SimpleNamespace(
        lower=np.zeros(2), upper=np.full(2, 5.0), of_effects=np.ones(2, dtype=bool), runs=runs
    )
    start = np.array([0.2, 0.2])
    state = np.random.get_state()[1].copy()  # noqa: NPY002 - what must not change
    cost = float(np.sum(ragged(start) ** 2))
    found = evolve(problem, start, cost, GENERATIONS)
    np.testing.assert_allclose(found, [3.0, 1.5], atol=0.1)
    again = evolve(problem, start, cost, GENERATIONS)
    np.testing.assert_array_equal(again, found)
    # The user's own generator is left alone.
    np.testing.assert_array_equal(np.random.get_state()[1], state)  # noqa: NPY002
    unchanged = evolve(problem, start, 0.0, 2)  # what is no better is not taken
    np.testing.assert_array_equal(unchanged, start)
