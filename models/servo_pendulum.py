r"""A pendulum on a voltage-driven position servo with gear friction, such as the Dynamixel X series.

.. math:: J\ddot q = \tau_m + \tau_e - b\dot q - \tau_f

1. firmware: duty :math:`\delta = \mathrm{sat}_1(k_p e_c / (256\cdot 885))`, with the error :math:`e_c` in encoder
   counts of 1/4096 turn and 885 the full scale of its PWM register;
2. motor: current :math:`i = (\delta U - k_t\dot q) / R` up to a limit, torque :math:`\tau_m = k_t (1 - \sigma|i|) i`,
   all seen from the output shaft, and zero while the servo is switched off, when its bridge is open;
3. load: :math:`\tau_e = -m g l \sin(q + q_0) - \tau_b`, q = 0 hanging down;
4. friction: :math:`\tau_f` opposes the motion and holds what it can, :math:`|\tau_f| \le F`,
   :math:`F = F_d(\dot q) + (1 + r e^{-(\dot q/v_s)^2})(1 + c|\tau_m - \tau_e|)\,|s_m\tau_m - s_e\tau_e|`: a dry level
   (``friction.dry``), and the shares of motor torque and load that the gear loses, larger by r at rest
   and growing with the torque it carries. Holding a load, both torques add up. With c = 0 and
   :math:`s_m = s_e` this is model M3 (r = 0) or M4, with different shares M5 of Duclusaud et al. 2025
   (arXiv 2410.08650), whose Stribeck exponent is 2 here; they grow as the square in M6.

The friction is the set-valued one: a step that it can stop ends at rest, so that a stuck servo stays
stuck at any step size. Not modelled: backlash, the motor's inductance, the supply's resistance. The factor
256 of (1) is what XL330 logs show; the maker's manual of the X series prints 128.
"""

from typing import Any, NamedTuple

import numpy as np

from . import friction

GRAVITY = 9.80665  # [m/s^2]
COUNTS_PER_TURN = 4096
PWM_FULL_SCALE = 885  # of the firmware's register, 100 %
GAIN_UNIT = 256.0  # of the firmware's proportional gain
SHARP = 1e-9  # width of the sign inside the friction's level [rad/s]


class ServoPendulum(NamedTuple):
    """Constants of the pendulum and its servo, from the output shaft."""

    inertia: float  # J, load and rotor [kg m^2]
    gravity: float  # m g l [N m]
    zero: float  # q_0, where the load hangs less the encoder's zero [rad]
    bias: float  # load that opposes positive motion [N m]
    torque_constant: float  # k_t [N m/A or V s/rad]
    resistance: float  # R [ohm]
    viscous: float  # b [N m s/rad]
    forward: float  # dry level at positive speed [N m]
    backward: float  # dry level at negative speed [N m]
    breakaway: float  # what the level has on top of that at standstill [N m]
    stribeck_speed: float  # over which the breakaway decays [rad/s]
    motor_share: float  # s_m [-]
    load_share: float  # s_e [-]
    rest_share: float  # r, what both shares have on top at standstill, relative [-]
    growth: float  # c, of the shares with the torque that the gear carries [1/(N m)]
    droop: float  # share of the torque constant lost per ampere [1/A]
    limit: float  # largest current [A]
    lag: float  # time constant of the voltage [s]
    delay: float  # of the voltage [s]


def ideal_servo(
    inertia: float, gravity: float, torque_constant: float, resistance: float
) -> ServoPendulum:
    """A pendulum without friction on a servo without flaws."""
    return ServoPendulum(
        inertia=inertia, gravity=gravity, zero=0.0, bias=0.0, torque_constant=torque_constant,
        resistance=resistance, viscous=0.0, forward=0.0, backward=0.0, breakaway=0.0,
        stribeck_speed=1.0, motor_share=0.0, load_share=0.0, rest_share=0.0, growth=0.0, droop=0.0, limit=np.inf, lag=0.0,
        delay=0.0,
    )  # fmt: skip


def duty(error: Any, gain: Any) -> Any:
    """Duty cycle (1) in [-1, 1] at a position error [rad] and the firmware's gain."""
    counts = error * COUNTS_PER_TURN / (2.0 * np.pi)
    return min(max(gain * counts / (GAIN_UNIT * PWM_FULL_SCALE), -1.0), 1.0)


def counted(position: Any) -> Any:
    """What the encoder reads of a position [rad]."""
    step = 2.0 * np.pi / COUNTS_PER_TURN
    return step * np.floor(position / step + 0.5)


def motor_torque(voltage: Any, rate: Any, servo: Any) -> Any:
    """Torque (2) of the connected motor [N m]."""
    current = (voltage - servo.torque_constant * rate) / servo.resistance
    current = min(max(current, -servo.limit), servo.limit)
    return servo.torque_constant * (1.0 - servo.droop * np.abs(current)) * current


def load_torque(position: Any, servo: Any) -> Any:
    """Torque (3) of the load [N m]."""
    return -servo.gravity * np.sin(position + servo.zero) - servo.bias


def friction_budget(rate: Any, motor: Any, load: Any, servo: Any) -> Any:
    """Largest friction F (4) [N m] at the torques of motor and load."""
    level = friction.dry(
        rate, servo.forward, servo.backward, servo.breakaway, servo.stribeck_speed, SHARP
    )
    ratio = rate / servo.stribeck_speed
    lost = np.abs(servo.motor_share * motor - servo.load_share * load)
    lost *= 1.0 + servo.growth * np.abs(motor - load)
    return np.abs(level) + (1.0 + servo.rest_share * np.exp(-ratio * ratio)) * lost


def stopped(rate: Any, most: Any) -> Any:
    """A rate that friction may change by ``most`` towards rest, and not beyond."""
    return np.sign(rate) * max(np.abs(rate) - most, 0.0)


def lagged(state: Any, voltage: Any, lag: Any, h: Any) -> Any:
    """State of the first-order lag after ``h`` seconds at a voltage; exact."""
    if lag <= 0.0:
        return voltage
    return voltage + (state - voltage) * np.exp(-h / lag)


def step(q: Any, v: Any, voltage: Any, connected: Any, h: Any, servo: Any) -> Any:
    """Position and rate after ``h`` seconds at a voltage [V]; ``connected`` is 1 or 0.

    Half a drift, a kick, half a drift: second order while moving. Damping is taken at the mean rate.
    """
    middle = q + 0.5 * h * v
    load = load_torque(middle, servo)
    motor = connected * motor_torque(voltage, v, servo)
    braking = connected * servo.torque_constant * servo.torque_constant / servo.resistance
    # The torques hold their damping at the old rate: half of it moves to the new one.
    heavy = servo.inertia + 0.5 * h * (servo.viscous + braking)
    free = v + h * (motor + load - servo.viscous * v) / heavy
    rate = stopped(free, h * friction_budget(free, motor, load, servo) / heavy)
    return middle + 0.5 * h * rate, rate
