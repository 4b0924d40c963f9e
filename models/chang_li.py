r"""Closed-form step of a stick-slip actuator with Coulomb friction (Chang and Li 1999).

Their equations (section 2.2 of Damani 2013) for a stiff stack that follows its voltage: it retracts by the
stroke D in the flyback time :math:`t_f` at speed :math:`u = D/t_f`, and the ramp is too slow to slip.

1. flyback: the slider falls back with :math:`(F_c + F)/m`, until it is as fast as the stack;
2. after it: the slider brakes with :math:`(F_c - F)/m`;
3. step = D less both distances. While :math:`t_f (F_c + F)/m < u` it is

   :math:`D - t_f^2 \frac{F_c + F}{m}\,\frac{F_c}{F_c - F}`

so that the loss falls with inertia and grows with load, faster than linearly. As in the source there is
neither presliding nor hysteresis nor a ringing stack; a frame that recoils is not modelled.
"""

from typing import Any


def step(stroke: float, flyback: float, coulomb: float, mass: float, load: float) -> float:
    """Net motion per step [m] for stroke [m], flyback time [s], friction [N], mass [kg], load [N].

    Negative when the slider is thrown back further than the stroke. Raises ValueError if the load
    exceeds the friction, which then holds nothing.
    """
    if not abs(load) < coulomb:
        raise ValueError(
            f"load {load} N exceeds the friction {coulomb} N; expected a load the contact can hold"
        )
    speed = stroke / flyback
    dragged = min(flyback, speed * mass / (coulomb + load))
    reached = dragged * (coulomb + load) / mass
    back = 0.5 * reached * dragged + reached * (flyback - dragged)
    braking = 0.5 * reached**2 * mass / (coulomb - load)
    return stroke - back - braking


def loss_factor(ratio: Any) -> Any:
    """Distance lost by (3) over what is lost without load; ``ratio`` is load over friction, F/F_c, below 1.

    The loss itself is :math:`t_f^2 F_c/m` without load. Floats or arrays.
    """
    return (1.0 + ratio) / (1.0 - ratio)
