"""The industry's test cycle: printed dimensions, smoothness, and the rounded version."""

import numpy as np
import pytest

from gapscope.models.pmc.cycle import IndustryCycle, LameCycle, Placement

PLACE = Placement(x=0.3, y=0.29, z=-0.35, phi=-76.0, direction=0.7)
CYCLES = [
    IndustryCycle(placement=PLACE),
    LameCycle(placement=PLACE),
    LameCycle(placement=PLACE, corner_up=0.015, corner_across=0.05, turn=-np.pi),
]


def test_printed_cycle():
    """25-300-25 mm with half a turn; 350 + 1000 + 350 ms each way is the printed 0.3 Hz."""
    cycle = IndustryCycle(placement=PLACE)
    corners = cycle.sample([0.0, 0.35, 1.35, 1.7, 3.4])[0]
    a, b, c, d, again = corners
    assert b - a == pytest.approx([0.0, 0.0, 0.025, 0.0], abs=1e-12)
    assert np.hypot(*(c - b)[:2]) == pytest.approx(0.300)
    assert (c - b)[3] == pytest.approx(np.pi)
    assert d - c == pytest.approx([0.0, 0.0, -0.025, 0.0], abs=1e-12)
    assert again == pytest.approx(a)
    assert 1.0 / cycle.period == pytest.approx(0.3, abs=0.01)
    assert 0.5 * (a + d)[:2] == pytest.approx([PLACE.x, PLACE.y])
    assert 0.5 * (a + d)[3] == pytest.approx(PLACE.phi)


@pytest.mark.parametrize("cycle", CYCLES)
def test_rates_and_accelerations_are_derivatives(cycle):
    """Central differences over 0.1 ms: error h^2/6 times the third derivative, relative 1e-5 here."""
    t = np.linspace(0.011, cycle.period - 0.011, 701)
    step = 1e-4
    ahead, behind = cycle.sample(t + step), cycle.sample(t - step)
    _, rates, accelerations = cycle.sample(t)
    for low, high, exact in (
        (behind[0], ahead[0], rates),
        (behind[1], ahead[1], accelerations),
    ):
        difference = (high - low) / (2.0 * step)
        assert np.abs(difference - exact).max() < 2e-4 * np.abs(exact).max()


@pytest.mark.parametrize("cycle", CYCLES)
def test_starts_and_turns_round_at_rest(cycle):
    _, rates, accelerations = cycle.sample([0.0, 0.5 * cycle.period, cycle.period])
    assert np.abs(rates).max() < 1e-12
    assert np.abs(accelerations).max() < 1e-9


def test_rounded_corner_lies_on_the_lame_curve():
    cycle = LameCycle(placement=PLACE)
    poses = cycle.sample(np.linspace(0.0, cycle.time, 2001))[0]
    way = (poses[:, :2] - poses[0, :2]) @ [np.cos(PLACE.direction), np.sin(PLACE.direction)]
    height = poses[:, 2] - PLACE.z
    corner = (way > 0.0) & (way < cycle.corner_across)
    lame = (1.0 - way / cycle.corner_across) ** 3 + (height / cycle.corner_up) ** 3
    assert lame[corner] == pytest.approx(1.0, abs=1e-7)
    assert poses[-1] - poses[0] == pytest.approx(
        [0.3 * np.cos(0.7), 0.3 * np.sin(0.7), 0.0, np.pi], abs=1e-9
    )


def test_rounding_lowers_the_peak_acceleration():
    """The point of the smooth version: less peak acceleration in the same time."""
    peaks = []
    for cycle in CYCLES[:2]:
        accelerations = cycle.sample(np.linspace(0.0, cycle.period, 4001))[2]
        peaks.append(np.linalg.norm(accelerations[:, :3], axis=1).max())
    assert peaks[1] < 0.8 * peaks[0]


def test_impossible_cycles_are_refused():
    with pytest.raises(ValueError, match="travel_time"):
        IndustryCycle(placement=PLACE, travel_time=0.0)
    with pytest.raises(ValueError, match="does not fit"):
        LameCycle(placement=PLACE, corner_up=0.03)
