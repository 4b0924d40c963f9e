"""Discrete-time plant of an n-shaft drive: one Runge-Kutta step per sample, exactly repeatable."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ..models import drive as drive_law
from ..models import leaf_kernels
from ..models.drive import Drive
from . import scalars


class SampledDrivePlant(LeafSystem):
    r"""A drive moved on by ``drive.ode4_step`` under torques held over each sample.

    The same compiled step as the batch loop ``drive_kernels.simulate``, so that both agree.

    | port | size | unit |
    |---|---|---|
    | in  `torque`   | motors | N m or N, reaches the first shafts |
    | out `position` | motors | rad or m |
    | out `velocity` | motors | rad/s or m/s |
    | out `state`    | 2 shafts | all positions, then all velocities |

    Discrete state every ``period`` seconds: positions and velocities of the shafts, deflections of the
    bristles. ``substeps`` Runge-Kutta steps a sample, for stiff couplings. Numeric parameters as in
    ``DrivePlant``, here with the presliding stiffness. Torques act from the sample on at which they
    are read. Raises ValueError if ``period`` or ``substeps`` is not positive.
    """

    INERTIA_INVERSE, ELEMENT, LOAD, COUPLING = range(4)

    def __init__(
        self, drive: Drive, period: float, *, motors: int | None = None, substeps: int = 1
    ) -> None:
        LeafSystem.__init__(self)
        self.period = scalars.positive(self, "period", period, "s")
        if substeps < 1:
            raise ValueError(f"SampledDrivePlant: substeps is {substeps}; expected 1 or more")
        self.substeps = substeps
        self.drive = drive.copy()
        self.shafts = self.drive.shaft.shape[0]
        self.motors = self.shafts if motors is None else motors
        for values in (
            self.drive.inertia_inverse,
            self.drive.element,
            self.drive.shaft[:, : drive_law.DELAY],
            self.drive.coupling[:, drive_law.COUPLING_STIFFNESS :],
        ):
            scalars.declare_parameter(self, values)
        joined = self.drive.coupling[:, : drive_law.COUPLING_STIFFNESS]
        self._joined = np.ascontiguousarray(joined)
        self.DeclareDiscreteState(2 * self.shafts + len(self.drive.element))
        self.DeclareVectorInputPort("torque", self.motors)
        state = {self.xd_ticket()}
        for name, size, first in (
            ("position", self.motors, 0),
            ("velocity", self.motors, self.shafts),
            ("state", 2 * self.shafts, 0),
        ):
            self.DeclareVectorOutputPort(
                name, size, _part(first, size), prerequisites_of_calc=state
            )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._step)

    def drive_of(self, context: Any) -> Drive:
        """The drive with the constants of this context."""
        n, m, c = self.shafts, len(self.drive.element), len(self.drive.coupling)
        coupling = self.drive.coupling.copy()
        coupling[:, drive_law.COUPLING_STIFFNESS :] = scalars.parameter(
            context, self.COUPLING, c, 3
        )
        return Drive(
            scalars.parameter(context, self.INERTIA_INVERSE, n, n),
            self.drive.elements,
            scalars.parameter(context, self.ELEMENT, m, self.drive.element.shape[1]),
            scalars.parameter(context, self.LOAD, n, drive_law.DELAY),
            coupling,
        )

    def _step(self, context: Any, discrete_state: Any) -> None:
        leaf_kernels.move(
            context.get_discrete_state_vector().value(),
            scalars.numbered(self, context, 0),
            context.get_time(),
            self.period,
            self.substeps,
            scalars.constants(context, self.INERTIA_INVERSE),
            self.drive.elements,
            scalars.constants(context, self.ELEMENT),
            scalars.constants(context, self.LOAD),
            self._joined,
            scalars.constants(context, self.COUPLING),
            discrete_state.get_mutable_value(),
        )


def _part(first: int, size: int) -> Any:
    def calc(context: Any, output: Any) -> None:
        output.SetFromVector(context.get_discrete_state_vector().value()[first : first + size])

    return calc
