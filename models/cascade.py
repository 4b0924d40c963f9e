r"""Cascaded control of one servo axis, one sample at a time (Roldan, sections 3.3.1, 3.3.2 and 4.1.3).

1. position (Fig. 3.13): :math:`\dot\theta_0 = (k_v e + f \dot q_0) / i_R`, low-passed; f = 0 without feed-forward
2. velocity and current: :math:`u = u_0 + k_P e + k_I \int e`, clipped; the integral waits while the clip holds u
   back; u_0 is fed forward, zero for none

Each loop runs with its own sample time; the filters are exact for inputs held over it. Units: joint m or rad,
motor rad, currents A, voltages V.
"""

from typing import Any

from . import control


def rate_command(
    reference: Any, position: Any, rate: Any, gain: Any, feedforward: Any, per_motor: Any
) -> Any:
    """Motor rate [rad/s] that the position loop (1) asks for, before its filter; ``per_motor`` is i_R."""
    return (gain * (reference - position) + feedforward * rate) / per_motor


def proportional_integral(
    error: Any, integral: Any, kp: Any, ki: Any, limit: float, dt: float, feedforward: Any = 0.0
) -> tuple[Any, Any]:
    """Output of (2) and the next integral of the error; ``limit`` is a float, infinite for none."""
    wanted = feedforward + kp * error + ki * integral
    output = control.clip(wanted, limit)
    held = wanted != output and wanted * error > 0.0
    return output, integral if held else integral + dt * error
