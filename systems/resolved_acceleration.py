"""Resolved-acceleration controller: computed torque with gains for translation and rotation."""

from typing import Any

from numpy.typing import ArrayLike
from pydrake.systems.framework import LeafSystem

from ..models.c_drive_controllers import task_gain
from . import scalars
from .computed_torque import servo_torque


class ResolvedAcceleration(LeafSystem):
    r"""Torque :math:`\tau = M(\ddot\psi_d + J^{-1}(K_P J e + K_D J \dot e)) + c D \tilde{\dot\psi}`.

    Friedlaender 2015, section 4.6.4: the servo portion of computed torque is that of (4.37a).

    | port | size | unit |
    |---|---|---|
    | in  `acceleration` | 2 | rad/s^2, of the reference |
    | in  `error`        | 2 | rad, motors (L, R) |
    | in  `error_rate`   | 2 | rad/s, from a ``FilteredDerivative`` |
    | in  `rate`         | 2 | rad/s, from a ``RateObserver`` |
    | out `torque`       | 2 | N m, motors (L, R) |

    No state. Numeric parameters ``KP`` [1/s^2] and ``KD`` [1/s]: (translation, rotation); ``INERTIA`` M
    and ``DAMPING`` c D, (2, 2), as the controller believes them to be; ``LEAD``: p_c [m/rev], positive.

    Why it became unstable in the thesis when k_P^t != k_P^r: different gains alone do not do it, since
    J^-1 K J, M and D share their eigenvectors and the loop splits into translation and rotation, each
    with a limit of its own. But the gains of Table 5-1 already lie at those limits once the torque path is
    taken as printed (0.6 ms torque filter, Appendix A; 0.5 ms torque loop, section 4.6.2): 37600 and
    35200 1/s^2 against 35000 printed, and 48 N m/rad against 45 for PD. Raising either gain leaves the
    stable region: 2.5 times in rotation, the ratio of the task-space PD, grows by 28 to 45 1/s (the lower
    with k_D raised alike), where the ideal torque path of the thesis's simulation shows nothing.
    Inverse dynamics already gives rotation 158 N m/rad, six times translation and 1.4 times TS.
    A loop that becomes unstable because one gain is *lowered* remains unexplained, and the gains that
    were tried are not printed. Numbers and figures: ``gapscope compare resolved-acceleration``.
    """

    KP, KD, INERTIA, DAMPING, LEAD = range(5)

    def __init__(
        self,
        *,
        kp: tuple[float, float],
        kd: tuple[float, float],
        inertia: ArrayLike,
        damping: ArrayLike,
        lead: float,
    ) -> None:
        LeafSystem.__init__(self)
        for values in (kp, kd, inertia, damping, [scalars.positive(self, "lead", lead, "m/rev")]):
            scalars.declare_parameter(self, values)
        for name in ("acceleration", "error", "error_rate", "rate"):
            self.DeclareVectorInputPort(name, 2)
        self.DeclareVectorOutputPort("torque", 2, self._torque)

    def _torque(self, context: Any, output: Any) -> None:
        lead = context.get_numeric_parameter(self.LEAD)[0]
        kp, kd = (scalars.parameter(context, gain, 2) for gain in (self.KP, self.KD))
        kp, kd = task_gain(kp[0], kp[1], lead), task_gain(kd[0], kd[1], lead)
        inertia, damping = (
            scalars.parameter(context, matrix, 2, 2) for matrix in (self.INERTIA, self.DAMPING)
        )
        output.SetFromVector(servo_torque(self, context, kp, kd, inertia, damping))
