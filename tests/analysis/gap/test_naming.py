"""What a fitted form is called, and how parameters that balance each other are dropped."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import least_squares

from gapscope.analysis.gap.effects import friction_stribeck
from gapscope.analysis.gap.effects.base import parameter
from gapscope.analysis.gap.fitting import fit
from gapscope.analysis.gap.hypothesis import Hypothesis
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.gap.prediction import Predictor
from gapscope.analysis.gap.pruning import _balanced, _slight
from gapscope.models import friction


def law(share, speed, width):
    return {"breakaway_share": share, "stribeck_speed": speed, "width": width}


def test_fall_is_that_of_the_law():
    """Far below the decay the sign is complete: the law falls by its breakaway share."""
    assert friction_stribeck.fall(law(0.4, 5.0, 0.01)) == pytest.approx(0.4, abs=1e-3)
    speeds = np.linspace(0.0, 10.0, 100_001)
    peak = friction.dry(speeds, 1.0, 1.0, 0.5, 1.0, 0.5).max()
    assert friction_stribeck.fall(law(0.5, 1.0, 0.5)) == pytest.approx(peak - 1.0, abs=1e-5)


def test_a_law_that_only_shapes_the_corner_does_not_fall():
    """v / sqrt(v^2 + w^2) rises everywhere; its best Gaussian form falls by less than 5 %."""
    speeds = np.linspace(-3.0, 3.0, 601)
    wanted = speeds / np.hypot(speeds, 0.3)

    def misfit(x):
        return friction.dry(speeds, 1.0, 1.0, x[0], x[1], x[2]) - wanted

    found = least_squares(misfit, [0.5, 0.4, 0.4])
    assert np.abs(found.fun).max() < 0.05
    assert found.x[0] > 0.3
    assert friction_stribeck.fall(law(*found.x)) < friction_stribeck.LEAST_FALL


def test_a_dropped_coefficient_gives_the_own_one_back(nominal_logset):
    machine, runs = read_machine(load_logset(nominal_logset))
    form = next(f for f in machine.forms(runs) if f.effect == "friction.viscous" and not f.refined)
    whole = Hypothesis(forms=(form,))
    own = {name for effect, p in whole.free(machine) if effect == "" for name in [p.name]}
    assert own.isdisjoint({"beta_left", "beta_right", "gamma"})
    fewer = whole.drop(("friction.viscous", "viscous_left"))
    own = {name for effect, p in fewer.free(machine) if effect == "" for name in [p.name]}
    assert own & {"beta_left", "beta_right", "gamma"} == {"beta_left"}


def test_what_balanced_a_dropped_parameter_follows_it(nominal_logset):
    """The search without it begins where the linearised loss without it is least, inside the bounds."""
    machine, runs = read_machine(load_logset(nominal_logset))
    predictor = Predictor(machine, runs[:1])
    rng = np.random.default_rng(9)
    names, lower = ("first", "second", "third"), (-np.inf, -np.inf, 0.0)
    free = [("effect", parameter(name, "-", 2.0, lower=low)) for name, low in zip(names, lower)]
    jacobian = rng.normal(size=(500, 3))
    jacobian[:, 1] = jacobian[:, 0] + 1e-6 * rng.normal(size=500)
    current = replace(
        fit(predictor, Hypothesis()),
        hypothesis=SimpleNamespace(free=lambda machine: free, rough=False),
        keys=tuple(("effect", name) for name in names),
        values=np.array([40.0, -38.0, 1.0]),
        jacobian=jacobian,
        residual=np.zeros(500),
    )
    moved = _balanced(predictor, current, [("effect", "first")])
    assert moved.by_key()["effect", "second"] == pytest.approx(2.0, abs=1e-3)
    assert moved.by_key()["effect", "third"] == pytest.approx(1.0, abs=1e-3)


def test_values_give_a_form_its_name(nominal_logset):
    """A Stribeck fit becomes dry friction with the same law, place and number of parameters."""
    machine, runs = read_machine(load_logset(nominal_logset))
    form = next(f for f in machine.forms(runs) if f.effect == "friction.stribeck" and not f.refined)
    predictor = Predictor(machine, runs[:1])
    start = fit(predictor, Hypothesis(forms=(form,)), steps=1)
    rounding = {"breakaway_share": 0.7, "stribeck_speed": 0.43, "width": 0.54, "level_left": 0.1}
    falling = {**rounding, "stribeck_speed": 4.3}
    for values, name in ((rounding, "friction.coulomb"), (falling, "friction.stribeck")):
        vector = np.array([values.get(name, v) for (_, name), v in zip(start.keys, start.values)])
        found = replace(start, values=vector).called_by_values()
        assert found.hypothesis.ids == (name,)
        plants = [
            f.hypothesis.plant(machine, f.by_key()) for f in (found, replace(start, values=vector))
        ]
        assert np.array_equal(plants[0].drive.element, plants[1].drive.element)


@pytest.mark.parametrize(
    ("importance", "kept"), [((0.01, 75.0), False), ((0.03, 75.0), True), ((0.01, 5.0), True)]
)
def test_a_place_goes_where_it_adds_little_to_the_fit_and_to_its_effect(importance, kept):
    keys = (("inertia.payload", "extra_rotors"), ("inertia.payload", "extra_platform"))
    current = SimpleNamespace(keys=keys, importance=importance)
    assert _slight(current, (importance[0], keys[0])) is not kept
