"""Continuous-time plant of an n-shaft drive, such as the C-drive, for any of Drake's scalars."""

from typing import Any

import numpy as np
from pydrake.symbolic import Expression
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from ..models import drive as drive_law
from ..models import drive_kernels
from ..models.drive import Drive
from . import scalars


@TemplateSystem.define("DrivePlant_")
def DrivePlant_(T: Any) -> Any:
    """Instantiate ``DrivePlant`` for the scalar ``T``."""

    class Impl(LeafSystem_[T]):
        r"""A drive: :math:`M \ddot q + E^T f(E \dot q) + h(q) = \tau` (``models/drive.py``, eq. 1-3).

        With ``c_drive.drive(parameters)`` this is the C-drive (Friedlaender 2015, eq. 2.5).

        | port | size | unit |
        |---|---|---|
        | in  `torque`   | motors | N m or N, reaches the first shafts |
        | out `position` | motors | rad or m |
        | out `velocity` | motors | rad/s or m/s |
        | out `state`    | 2 shafts | all positions, then all velocities |

        Continuous state: positions, then velocities of all shafts. Numeric parameters of the
        Context: ``INERTIA_INVERSE`` (n, n), ``ELEMENT`` (m, 9), ``LOAD`` (n, 7: the columns of
        ``Drive.shaft`` before DELAY) and ``COUPLING`` (c, 3: stiffness, damping, gap). The presliding
        stiffness and the shafts a coupling joins are structure, not parameters.

        Delay, gain, limit and lag of the actuator belong to ``TorqueAmplifier``. Raises ValueError
        for a drive with presliding friction (``SampledDrivePlant`` has it) and, for Expression,
        with flexible couplings, whose clearance branches.
        """

        INERTIA_INVERSE, ELEMENT, LOAD, COUPLING = range(4)

        def _construct(
            self, drive: Drive, motors: int | None = None, converter: Any = None
        ) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self.drive = drive.copy()
            self.shafts = self.drive.shaft.shape[0]
            self.motors = self.shafts if motors is None else motors
            _check(self.drive, T)
            for values in (
                self.drive.inertia_inverse,
                self.drive.element,
                self.drive.shaft[:, : drive_law.DELAY],
                self.drive.coupling[:, drive_law.COUPLING_STIFFNESS :],
            ):
                scalars.declare_parameter(self, values, T)
            self.DeclareContinuousState(self.shafts, self.shafts, 0)
            self.DeclareVectorInputPort("torque", self.motors)
            state = {self.xc_ticket()}
            for name, size, calc in (
                ("position", self.motors, self._position),
                ("velocity", self.motors, self._velocity),
                ("state", 2 * self.shafts, self._state),
            ):
                self.DeclareVectorOutputPort(name, size, calc, prerequisites_of_calc=state)

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(self, other.drive, other.motors, converter=converter)

        def drive_of(self, context: Any) -> Drive:
            """The drive with the constants of this context."""
            n, m, c = self.shafts, len(self.drive.element), len(self.drive.coupling)
            element = scalars.parameter(context, self.ELEMENT, m, len(self.drive.element[0]))
            load = scalars.parameter(context, self.LOAD, n, drive_law.DELAY)
            coupling = self.drive.coupling.astype(object if T is not float else float)
            coupling[:, drive_law.COUPLING_STIFFNESS :] = scalars.parameter(
                context, self.COUPLING, c, 3
            )
            if T is not float:
                element[:, drive_law.STIFFNESS] = 0.0
                exponents = self.drive.element[:, drive_law.STRIBECK_EXPONENT]
                element[:, drive_law.STRIBECK_EXPONENT] = exponents
                _never_zero(
                    element,
                    (
                        drive_law.VISCOUS_SKEW,
                        drive_law.FORWARD,
                        drive_law.BACKWARD,
                        drive_law.BREAKAWAY,
                        drive_law.FADE,
                    ),
                )
                _never_zero(
                    load,
                    (
                        drive_law.LOAD_FRICTION,
                        drive_law.NET_LOAD_FRICTION,
                        drive_law.RIPPLE_COS,
                        drive_law.RIPPLE_SIN,
                    ),
                )
            return Drive(
                scalars.parameter(context, self.INERTIA_INVERSE, n, n),
                self.drive.elements,
                element,
                load,
                coupling,
            )

        def DoCalcTimeDerivatives(self, context: Any, derivatives: Any) -> None:
            n = self.shafts
            x = np.array(context.get_continuous_state_vector().CopyToVector())
            torque = np.zeros(n, dtype=x.dtype)
            torque[: self.motors] = scalars.signal(self, context, "torque")
            held = np.zeros(len(self.drive.element))
            work, out = np.zeros(n, dtype=x.dtype), np.zeros(n, dtype=x.dtype)
            law = drive_kernels.acceleration if T is float else drive_law.acceleration
            # Expression keeps NaN as a value of its variables, which NumPy takes for an accident.
            with np.errstate(invalid="ignore" if T is Expression else "warn"):
                law(
                    x[:n],
                    x[n:],
                    held,
                    torque,
                    context.get_time(),
                    self.drive_of(context),
                    work,
                    out,
                )
            derivatives.get_mutable_vector().SetFromVector(np.concatenate([x[n:], out]))

        def _position(self, context: Any, output: Any) -> None:
            x = context.get_continuous_state_vector().CopyToVector()
            output.SetFromVector(x[: self.motors])

        def _velocity(self, context: Any, output: Any) -> None:
            x = context.get_continuous_state_vector().CopyToVector()
            output.SetFromVector(x[self.shafts : self.shafts + self.motors])

        def _state(self, context: Any, output: Any) -> None:
            output.SetFromVector(context.get_continuous_state_vector().CopyToVector())

    return Impl


DrivePlant = DrivePlant_[None]


def _check(plant: Drive, scalar: Any) -> None:
    if np.any(plant.element[:, drive_law.STIFFNESS] > 0.0):
        raise ValueError(
            "DrivePlant: the drive has presliding friction; expected STIFFNESS = 0. "
            "Use SampledDrivePlant, whose bristles are integrated exactly over a step"
        )
    if scalar is Expression and len(plant.coupling):
        raise ValueError(
            "DrivePlant: the drive has flexible couplings; expected none for Expression, because "
            "clearance branches. Use float or AutoDiffXd"
        )


def _never_zero(array: Any, columns: tuple[int, ...]) -> None:
    for column in columns:
        for i in range(len(array)):
            array[i, column] = scalars.NeverZero(array[i, column])
