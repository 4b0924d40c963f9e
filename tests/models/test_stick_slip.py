"""The physical stick-slip actuator: hysteresis, contact, energy, and how its step depends on what."""

import time
from dataclasses import replace

import numpy as np
import pytest

from gapscope.models import chang_li, hysteresis, presliding, stick_slip
from gapscope.models.mm3a import actuators, dynamics
from gapscope.models.mm3a.arm import Arm, gravity_in_base
from gapscope.models.stick_slip import Actuator, Sawtooth, settled_step, simulate

WEIGHT = 0.002 * 9.81  # of link 3 [N]
ACTUATOR, DRIVE = Actuator(), Sawtooth()


def drive_through(voltages, rate_of):
    """Lost voltage along a path of small voltage increments, by the midpoint rule."""
    lost = [0.0]
    for increment in np.diff(voltages):
        middle = lost[-1] + 0.5 * rate_of(lost[-1], increment)
        lost.append(lost[-1] + rate_of(middle, increment))
    return np.array(lost)


def triangle(peak, cycles, n=4000):
    return np.concatenate(
        [np.concatenate([np.linspace(0, peak, n), np.linspace(peak, 0, n)])] * cycles
    )


def test_bouc_wen_is_rate_independent_and_loses_energy():
    alpha, beta, gamma = ACTUATOR.bouc_wen
    rate = hysteresis.bouc_wen_rate(3.0, 10.0, alpha, beta, gamma)
    assert hysteresis.bouc_wen_rate(3.0, 70.0, alpha, beta, gamma) == pytest.approx(7 * rate)
    voltage = triangle(80.0, 3)
    lost = drive_through(voltage, lambda v, dv: hysteresis.bouc_wen_rate(v, dv, alpha, beta, gamma))
    last = slice(2 * len(voltage) // 3, None)
    loop = -np.trapezoid(voltage[last] - lost[last], voltage[last])
    assert loop > 0.05 * 80.0**2  # displacement lags: the loop encloses positive work
    assert lost[last][0] == pytest.approx(lost[-1], rel=1e-3)  # closed


def test_maxwell_elements_yield_in_turn_and_return_on_the_doubled_curve():
    """Masing's rule: the unloading branch is the virgin curve scaled by two."""
    slopes, limits = (6.0e6, 3.0e6, 1.5e6), (3.0, 6.0, 9.0)
    charge = np.concatenate([np.linspace(0, 1e-5, 20001), np.linspace(1e-5, -1e-5, 40001)])
    volts = np.zeros(3)
    total = [0.0]
    for dq in np.diff(charge):
        for i in range(3):
            if hysteresis.element_sticks(volts[i], limits[i], dq):
                volts[i] += slopes[i] * dq
        total.append(volts.sum())
    total = np.array(total)
    virgin = total[:20001]
    expected = [sum(min(k * q, v) for k, v in zip(slopes, limits)) for q in charge[:20001]]
    # Each element overshoots its limit by less than one increment.
    np.testing.assert_allclose(virgin, expected, atol=sum(slopes) * 5e-10 * 1.01)
    back = total[20000] - total[20000:]
    doubled = np.interp(0.5 * (1e-5 - charge[20000:]), charge[:20001], virgin) * 2
    np.testing.assert_allclose(back, doubled, atol=0.02)


def test_charge_and_lost_voltage_obey_the_terminal_equation():
    """V = v(q) + (q - T x)/C, differentiated."""
    slope, T, C, dV, dx = 7.5e6, 0.47, 5e-8, 1e4, 3e-3
    dq = hysteresis.charge_rate(dV, dx, T, C, slope)
    assert slope * dq + (dq - T * dx) / C == pytest.approx(dV, rel=1e-14)


def test_contact_is_elastic_below_its_limit_and_lugre_is_not():
    assert presliding.plastic_share(1.0, 0.5e-7, 0.6e-7, 1e-7) == 0.0
    assert presliding.plastic_share(-1.0, 0.9e-7, 0.6e-7, 1e-7) == 0.0  # unloading
    assert presliding.plastic_share(1.0, 0.8e-7, 0.6e-7, 1e-7) == pytest.approx(0.5)
    assert presliding.plastic_share(1.0, 1.1e-7, 0.6e-7, 1e-7) == 1.0
    assert presliding.plastic_share(1.0, 1e-9, 0.0, 1e-7) == 1.0  # LuGre


@pytest.mark.parametrize("kind", ["none", "bouc_wen", "maxwell"])
def test_power_balance(kind):
    """Rate of kinetic and elastic energy = drive power - load power - heat, at random states."""
    a = replace(ACTUATOR, hysteresis=kind).constants()
    rng = np.random.default_rng(5)
    for _ in range(200):
        state = rng.normal(size=8) * [1e-6, 2e-3, 1e-6, 2e-3, 5e-8, 3, 3, 3]
        x, dx, _, dy, z, *lost = state
        voltage, slope, load = rng.uniform(0, 80), rng.normal() * 1e4, rng.normal() * 0.02
        rates = stick_slip.derivatives(state, voltage, slope, load, a)
        stored = (
            a.piezo_mass * dx * rates[1]
            + a.piezo_stiffness * x * dx
            + a.slider_mass * dy * rates[3]
            + a.presliding_stiffness * z * rates[4]
        )
        force, bristle_rate, _ = stick_slip.contact(dx - dy, z, a)
        heat = a.piezo_damping * dx**2 + force * (dx - dy)
        heat -= a.presliding_stiffness * z * bristle_rate
        power = a.transduction * (voltage - sum(lost)) * dx - load * dy
        scale = max(abs(power), abs(heat), 1e-6)
        assert stored == pytest.approx(power - heat, abs=1e-11 * scale)
        assert heat >= 0.0


def test_time_step_does_not_matter():
    """Half a thousandth at the default step, against one eight times finer."""
    fine = settled_step(ACTUATOR, DRIVE, load=0.5 * WEIGHT, time_step=2.5e-7)
    assert settled_step(ACTUATOR, DRIVE, load=0.5 * WEIGHT) == pytest.approx(fine, rel=5e-4)


@pytest.mark.parametrize("kind", ["none", "bouc_wen", "maxwell"])
def test_negative_steps_mirror_positive_ones(kind):
    """The settled actuator has no preferred direction: an asymmetry must come from elsewhere."""
    actuator = replace(ACTUATOR, hysteresis=kind)
    forward = settled_step(actuator, DRIVE, load=0.5 * WEIGHT)
    backward = settled_step(actuator, DRIVE, load=-0.5 * WEIGHT, direction=-1)
    assert backward == pytest.approx(-forward, rel=2e-3)


def test_defaults_have_the_printed_size_and_load_slope():
    """Fig. 4.13: a = 899 and 972 nm, |c| = 376 and 436 nm per weight of link 3. Chosen constants."""
    up, free, down = (1e9 * settled_step(ACTUATOR, DRIVE, load=f * WEIGHT) for f in (1, 0, -1))
    assert 899 <= free <= 972
    assert 376 <= 0.5 * (down - up) <= 436


def test_load_trend_is_monotone_and_steeper_against_the_load():
    """As Chang and Li's closed form, unlike the straight line of (4.4)."""
    loads = np.linspace(-1, 1, 9) * WEIGHT
    steps = np.array([settled_step(ACTUATOR, DRIVE, load=load) for load in loads])
    slopes = np.diff(steps)
    assert np.all(slopes < 0)
    assert np.all(np.diff(slopes) < 0)


def test_closed_form_of_chang_and_li_is_the_limit_of_a_rigid_contact():
    """Stiff stack and contact, no hysteresis or Stribeck peak: what is left is their model.

    Remaining differences: one presliding deflection (20 nm) and one period of the stack (1.5 % of the
    flyback), together below 5 % of the step. Lighter sliders catch up with the stack, and then bounce on
    the elastic contact: no Coulomb model follows that.
    """
    rigid = Actuator(
        hysteresis="none",
        breakaway=0.0,
        presliding_stiffness=5e6,
        presliding_damping=40.0,
        piezo_stiffness=6.4e7,
        piezo_damping=300.0,
        transduction=1.0,
    )
    stroke = 80.0 / 6.4e7
    for load in (-WEIGHT, 0.0, WEIGHT):
        for mass in (0.002, 0.004, 0.016):
            physical = settled_step(rigid, DRIVE, load=load, slider_mass=mass, time_step=1e-6)
            closed = chang_li.step(stroke, DRIVE.flyback, 0.1, mass, load)
            assert physical == pytest.approx(closed, abs=0.05 * stroke)


@pytest.mark.parametrize("ratio", [-0.5, 0.0, 0.3])
def test_loss_factor_is_the_loss_of_the_closed_form_over_that_without_load(ratio):
    """Also where each holds: what a heavier slider loses falls with its mass."""
    stroke, flyback, coulomb = 1e-5, 1e-4, 0.1
    for mass in (0.002, 0.005):
        lost = stroke - chang_li.step(stroke, flyback, coulomb, mass, ratio * coulomb)
        expected = flyback**2 * coulomb / mass * chang_li.loss_factor(ratio)
        assert lost == pytest.approx(expected, rel=1e-12)


def test_chang_li_takes_over_the_speed_of_the_stack_when_light():
    """A massless slider follows the stack both ways and is thrown back by no more than that."""
    assert chang_li.step(1e-6, 1e-4, 0.1, 1e-12, 0.0) == pytest.approx(0.0, abs=1e-14)
    assert chang_li.step(1e-6, 1e-4, 0.1, 1e3, 0.0) == pytest.approx(1e-6, rel=1e-5)
    with pytest.raises(ValueError, match="exceeds the friction"):
        chang_li.step(1e-6, 1e-4, 0.1, 0.002, 0.2)


def test_inertia_raises_the_step_which_chapter_5_did_not_observe():
    """A heavier slider falls back less: at fixed friction the rotary step grows with q3."""
    arm, joint = Arm(), actuators.elbow_actuator()
    inertias = [dynamics.mass_diagonal((0, -1.6, q3), arm)[1] for q3 in (0, 0.004, 0.008, 0.012)]
    assert np.all(np.diff([joint.step(1, 0.0, inertia) for inertia in inertias]) > 0)


def test_a_heavy_slider_steps_by_the_phase_of_its_swing():
    """Half a swing more per period turns its step up or down; a light slider's does not notice.

    So a fall with inertia can be had from this model, but it is interference and not a trend.
    """
    joint = actuators.elbow_actuator()
    soft = replace(joint.actuator, presliding_stiffness=1.0e6)
    changes = []
    for mass in (0.04, 0.433):
        half_swing = np.pi * np.sqrt(mass / soft.presliding_stiffness)
        usual, longer = (
            simulate(soft, replace(joint.drive, period=period), steps=100, slider_mass=mass)
            .steps[-10:]
            .mean()
            for period in (joint.drive.period, joint.drive.period + half_swing)
        )
        changes.append(abs(longer / usual - 1.0))
    assert changes[0] < 0.03
    assert changes[1] > 0.2


def test_inertia_force_along_the_ramp_is_nothing_to_the_stack():
    """The guess of section 5.4, a shorter stroke of the stack under inertia, fails by five decades."""
    joint = actuators.elbow_actuator()
    stroke = joint.actuator.transduction * joint.drive.amplitude / joint.actuator.piezo_stiffness
    inertia_force = 0.06 * stroke / joint.drive.period**2
    blocking_force = joint.actuator.transduction * joint.drive.amplitude
    assert inertia_force < 1e-4 * blocking_force


def test_friction_that_grows_with_the_overhang_turns_the_inertia_trend():
    """What could explain Fig. 5.7: bearing friction loaded by the tilting moment of the long arm.

    Doubled friction over the travel does; the 44 % by which the inertia grows do not.
    """
    arm, joint = Arm(), actuators.elbow_actuator()
    near, far = (dynamics.mass_diagonal((0, -1.6, q3), arm)[1] for q3 in (0, 0.012))
    steps = [
        replace(joint, actuator=replace(joint.actuator, coulomb=0.30 * growth)).step(1, 0.0, far)
        for growth in (far / near, 2.0)
    ]
    assert steps[1] < joint.step(1, 0.0, near) < 1.05 * steps[0]


def test_rotary_defaults_have_the_printed_size_and_load_effect():
    """Steps in 75-115 urad (section 6.2), load effect near |d| of Fig. 5.6. Chosen constants."""
    arm, parts = Arm(), actuators.joint_actuators()
    for q3, low, high in ((0.0, 3.0, 9.0), (0.012, 15.0, 25.0)):
        q = (0.0, -np.pi / 2, q3)
        up, free, down = (
            1e6
            * abs(actuators.physical_step(1, d, q, gravity_in_base(t, 0.0), (0, 0, 0), arm, parts))
            for d, t in ((1, 0.0), (1, -np.pi / 2), (-1, 0.0))
        )
        assert 75 <= free <= 115
        assert low <= 0.5 * (down - up) <= high


def test_voltage_has_a_threshold_and_then_grows_the_step():
    volts = np.array([5.0, 50.0, 60.0, 70.0, 80.0])
    steps = np.array([settled_step(ACTUATOR, replace(DRIVE, amplitude=v)) for v in volts])
    assert abs(steps[0]) < 2e-9
    assert np.all(np.diff(steps[1:]) > 0)


def test_a_slow_flyback_loses_the_step():
    quick, slow = (settled_step(ACTUATOR, replace(DRIVE, flyback=t)) for t in (5e-5, 1.6e-4))
    assert slow < 0.75 * quick


def test_frequency_hardly_matters_at_the_rate_of_the_thesis():
    slow, usual = (settled_step(ACTUATOR, replace(DRIVE, period=1 / f)) for f in (50, 100))
    assert usual == pytest.approx(slow, rel=0.03)


def test_unusable_constants_and_time_steps_are_refused():
    with pytest.raises(ValueError, match="unknown hysteresis 'preisach'"):
        Actuator(hysteresis="preisach")
    with pytest.raises(ValueError, match="coulomb is 0"):
        Actuator(coulomb=0.0)
    with pytest.raises(ValueError, match=r"elastic_share is 1\.0"):
        Actuator(elastic_share=1.0)
    with pytest.raises(ValueError, match="0 < flyback < period"):
        Sawtooth(flyback=0.02)
    with pytest.raises(ValueError, match="exceeds the friction"):
        simulate(ACTUATOR, DRIVE, load=0.11)
    with pytest.raises(ValueError, match="diverges at time_step"):
        simulate(ACTUATOR, DRIVE, time_step=2e-5)


def test_actuator_runs_fifty_times_faster_than_real_time():
    simulate(ACTUATOR, DRIVE, steps=1)
    best = np.inf
    for _ in range(5):
        before = time.process_time()
        simulate(ACTUATOR, DRIVE, steps=100)
        best = min(best, time.process_time() - before)
    assert best < 100 * DRIVE.period / 50
