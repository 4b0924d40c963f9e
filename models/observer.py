r"""Minimum-order Luenberger observer of the C-drive (Friedlaender 2015, section 4.4.2).

In the decoupled coordinates :math:`\sigma = \sqrt E J \psi`, :math:`\varsigma = H^{-1}\dot\sigma`:

1. :math:`\dot\kappa = U \kappa + U L \sigma + Z u`, :math:`u = \sqrt E^{-1} J \tau` (4.22b, 4.22d);
2. :math:`\tilde\varsigma = \kappa + L \sigma` (4.22e), :math:`\tilde{\dot\psi} = J^{-1} \sqrt E^{-1} H
   \tilde\varsigma`;
3. :math:`U = -(1 + L) H`, with L from the poles by pole placement (4.24).

It needs viscous friction in both collar directions (H invertible).
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.signal import place_poles

from .c_drive import CDriveParameters
from .c_drive_state_space import collar_modes, output_matrix, to_input, to_sigma


class DiscreteObserver(NamedTuple):
    """Motor-rate observer: state kappa (n,), inputs psi (n,) [rad] and tau (n,) [N m].

    ``kappa' = transition kappa + from_position psi + from_torque tau``,
    ``rate = rate_from_state kappa + rate_from_position psi`` [rad/s]; all fields are (n, n).
    """

    transition: Any
    from_position: Any
    from_torque: Any
    rate_from_state: Any
    rate_from_position: Any


class ContinuousObserver(NamedTuple):
    """Motor-rate observer: state kappa (n,), inputs psi (n,) [rad] and tau (n,) [N m].

    ``d kappa/dt = from_state kappa + from_position psi + from_torque tau``, rate as in
    ``DiscreteObserver``; all fields are (n, n).
    """

    from_state: Any
    from_position: Any
    from_torque: Any
    rate_from_state: Any
    rate_from_position: Any


def observer_gain(h: NDArray[np.float64], poles: Sequence[complex]) -> NDArray[np.float64]:
    """L of eq. (4.24), (n, n), for H = diag(h) [1/s] and the observer poles [rad/s].

    Raises ValueError if a pole is not in the open left half plane (4.25).
    """
    if not np.all(np.real(poles) < 0.0):
        raise ValueError(f"observer poles are {list(poles)}; expected negative real parts")
    placed = place_poles(-np.diag(h), np.diag(h), np.asarray(poles))
    return np.asarray(np.real(placed.gain_matrix).T)


def continuous_observer(model: CDriveParameters, poles: Sequence[complex]) -> ContinuousObserver:
    """Observer (1)-(3) of this model with the given poles [rad/s].

    Raises ValueError if the model has no viscous friction or a pole is unstable.
    """
    h = collar_modes(model).rate
    if not np.all(h > 0.0):
        raise ValueError("the observer needs viscous friction in both directions of the collar")
    L = observer_gain(h, poles)
    U = -(np.eye(2) + L) @ np.diag(h)
    to_rate = output_matrix(model) @ np.diag(h)
    return ContinuousObserver(
        from_state=U,
        from_position=U @ L @ to_sigma(model),
        from_torque=np.diag(1.0 / h) @ to_input(model),
        rate_from_state=to_rate,
        rate_from_position=to_rate @ L @ to_sigma(model),
    )


def minimum_order_observer(
    model: CDriveParameters, poles: Sequence[complex], dt: float
) -> DiscreteObserver:
    """``continuous_observer`` for inputs held over samples of ``dt`` seconds, without error.

    Of a position that keeps moving, the held input is half a sample late: at constant speed the
    rate comes out too high by about ``-pole dt/2``, 30 % at the benchmark's -600 rad/s and 1 ms.
    Raises ValueError if the model has no viscous friction, a pole is unstable or dt not positive.
    """
    if not dt > 0.0:
        raise ValueError(f"dt is {dt}; expected a positive sample time in seconds")
    observer = continuous_observer(model, poles)
    transition = expm(observer.from_state * dt)
    held = np.linalg.solve(observer.from_state, transition - np.eye(2))
    return DiscreteObserver(
        transition=transition,
        from_position=held @ observer.from_position,
        from_torque=held @ observer.from_torque,
        rate_from_state=observer.rate_from_state,
        rate_from_position=observer.rate_from_position,
    )
