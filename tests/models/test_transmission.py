"""Drive trains: state space, transfer functions and modes agree; the belt axis resonates as printed."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import ss2tf

from gapscope.models import dc_motor, transmission
from gapscope.models.dc_motor import DCMotor
from gapscope.models.transmission import DriveTrain

S = 2j * np.pi * np.geomspace(0.3, 3000.0, 60)
TWO = DriveTrain(inertias=(2e-5, 3e-6), stiffnesses=(60.0,), dampings=(1e-4,))
FOUR = DriveTrain(
    inertias=(2e-5, 3e-6, 4e-6, 1e-5),
    stiffnesses=(60.0, 40.0, 90.0),
    dampings=(1e-4, 3e-4, 2e-4),
    bearings=(1e-5, 0.0, 2e-5, 0.0),
)


def by_state_space(train, s):
    a, b, c = train.state_space()
    return np.array([c @ np.linalg.solve(z * np.eye(len(a)) - a, b) for z in s])


@pytest.mark.parametrize("train", [TWO, FOUR])
def test_state_space_and_dynamic_stiffness_agree(train):
    expected = by_state_space(train, S)
    assert np.abs(train.response(S) / expected - 1.0).max() < 1e-9


@pytest.mark.parametrize("train", [TWO, FOUR])
def test_elimination_gives_the_same_chain_of_transfers(train):
    angles = train.response(S)[..., 0]
    expected = [angles[:, 0]] + [angles[:, i] / angles[:, i - 1] for i in range(1, angles.shape[1])]
    for found, wanted in zip(train.transfers(S), expected):
        assert np.abs(found / wanted - 1.0).max() < 1e-9


def test_printed_transfers_of_two_inertias_and_superposition():
    """(3.7), (3.8): what the motor does and what the disturbance does add up, with its sign."""
    transfer = transmission.two_inertia_transfer(2e-5, 3e-6, 1e-4, 60.0)
    angles = TWO.response(S)
    assert transfer["motor"](S) == pytest.approx(angles[:, 0, 0], rel=1e-9)
    assert (transfer["motor"](S) * transfer["load"](S)) == pytest.approx(angles[:, 1, 0], rel=1e-9)
    disturbed = -transfer["load_by_disturbance"](S)
    assert disturbed == pytest.approx(angles[:, 1, 1], rel=1e-9)
    assert (disturbed * transfer["motor_by_load"](S)) == pytest.approx(angles[:, 0, 1], rel=1e-9)


def test_one_inertia_is_its_transfer_and_its_state_space():
    train = DriveTrain(inertias=(1.3e-3,), bearings=(1.7e-3,))
    a, b, c = train.state_space()
    numerator, denominator = ss2tf(a, b, c, np.zeros((1, 2)))
    transfer = transmission.one_inertia_transfer(1.3e-3, 1.7e-3)
    assert np.polyval(numerator[0], S) / np.polyval(denominator, S) == pytest.approx(transfer(S))


def test_modes_sum_to_the_response_under_proportional_damping():
    stiff = (60.0, 40.0, 90.0)
    train = DriveTrain(
        inertias=FOUR.inertias, stiffnesses=stiff, dampings=tuple(2e-6 * k for k in stiff)
    )
    first, last = transmission.modal_response(train, S)
    angles = train.response(S)[..., 0]
    assert first == pytest.approx(angles[:, 0], rel=1e-8)
    assert last == pytest.approx(angles[:, -1] / angles[:, 0], rel=1e-8)


def test_free_train_keeps_its_energy():
    """Undamped, 50 periods of the mode at 1e-10 of relative tolerance."""
    train = DriveTrain(inertias=TWO.inertias, stiffnesses=TWO.stiffnesses, dampings=(0.0,))
    a, _, _ = train.state_space()
    span = 50 * 2.0 * np.pi / train.modes()[0][-1]
    run = solve_ivp(lambda t, x: a @ x, (0.0, span), [0.1, 0.0, 0.0, 30.0], rtol=1e-10, atol=1e-12)
    q, v = run.y[:2], run.y[2:]
    energy = 0.5 * np.einsum("it,ij,jt->t", v, train.inertia, v)
    energy += 0.5 * np.einsum("it,ij,jt->t", q, train.stiffness, q)
    assert energy == pytest.approx(np.full_like(energy, energy[0]), rel=1e-6)


def test_counts_and_signs_are_checked():
    with pytest.raises(ValueError, match="2 inertias, 0 stiffnesses"):
        DriveTrain(inertias=(1.0, 1.0))
    with pytest.raises(ValueError, match="not positive"):
        DriveTrain(inertias=(0.0,))
    with pytest.raises(ValueError, match="negative"):
        DriveTrain(inertias=(1.0,), bearings=(-1.0,))
    with pytest.raises(ValueError, match="expected none or 1"):
        DriveTrain(inertias=(1.0,), bearings=(1.0, 1.0))
    with pytest.raises(ValueError, match="resistance is 0"):
        DCMotor(resistance=0.0, inductance=1.0, torque_constant=1.0, emf_constant=1.0)
    with pytest.raises(ValueError, match="gear ratio is 0"):
        dc_motor.joint_per_motor(0.0)


def test_winding_follows_its_transfer_function():
    """Step of 1 V on a locked shaft: i = (1 - exp(-R t / L)) / R, and the pole of (3.3) is -R/L."""
    motor = DCMotor(resistance=0.3, inductance=8e-5, torque_constant=0.03, emf_constant=0.03)
    t = np.linspace(0.0, 1e-3, 20)
    run = solve_ivp(
        lambda t, i: dc_motor.winding_rate(i, 1.0, 0.0, 0.3, 8e-5, 0.03),
        (0.0, 1e-3), [0.0], t_eval=t, rtol=1e-9, atol=1e-12,
    )  # fmt: skip
    assert run.y[0] == pytest.approx((1.0 - np.exp(-0.3 / 8e-5 * t)) / 0.3, abs=1e-7)
    assert np.roots(motor.electric_transfer.denominator) == pytest.approx([-0.3 / 8e-5])
    # Steady, unloaded: the speed at which back-EMF takes all of the voltage.
    assert dc_motor.winding_rate(0.0, 3.0, 100.0, 0.3, 8e-5, 0.03) == pytest.approx(0.0)


def test_gear_and_guide_turn_motor_angles_into_joint_motion():
    assert dc_motor.joint_per_motor(40.0) == pytest.approx(1.0 / 40.0)
    turns = 2.0 * np.pi * 15.0
    assert turns * dc_motor.joint_per_motor(15.0, 0.1) == pytest.approx(0.1)
