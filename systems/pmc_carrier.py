"""The PepperMill-Carrier with its drives and encoders as a system, sampled and continuous."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import BasicVector_, LeafSystem, LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from ..models import encoder
from ..models.pmc import constants, dynamics, simulation
from ..models.pmc.parameters import PMCParameters


class SampledCarrier(LeafSystem):
    r"""Closed-form robot moved on by one ODE4 step per sample under held motor torques.

    :math:`M(w) w'' + c(w, w') = T^T \tau`, see ``models.pmc.dynamics``.

    | port | size | unit |
    |---|---|---|
    | in  `torque`   | 4 | N m, motors (L1, R1, L2, R2) |
    | out `joints`   | 4 | m, m, rad, rad: d1, d2, theta1, theta2 |
    | out `rates`    | 4 | m/s, m/s, rad/s, rad/s |
    | out `measured` | 4 | rad, motor angles from home as the encoders read them |

    Discrete state every ``period`` seconds: joints and rates. Numeric parameter ``CONSTANTS``: the vector of
    ``constants.to_vector``. Repeats ``simulation.simulate``. Torques beyond the motors' limit are cut.
    Raises ValueError if ``period`` is not positive.
    """

    CONSTANTS = 0

    def __init__(
        self, parameters: PMCParameters, home: ArrayLike, start: ArrayLike, period: float
    ) -> None:
        LeafSystem.__init__(self)
        if not period > 0.0:
            raise ValueError(f"SampledCarrier: period is {period}; expected a positive time [s]")
        self.period = period
        self.limit = parameters.torque_limit
        self.home = np.array(home, dtype=float)
        self.motor_map = constants.motor_map(parameters.drive.lead)
        bits = parameters.encoder_bits
        self.lsb = encoder.resolution(bits) if bits else 0.0
        values = constants.to_vector(constants.of(parameters))
        self.DeclareNumericParameter(BasicVector_[float](values))
        self.DeclareDiscreteState(np.concatenate([start, np.zeros(4)]))
        self.DeclareVectorInputPort("torque", 4)
        state = {self.xd_ticket()}
        for name, calc in (
            ("joints", lambda x: x[:4]),
            ("rates", lambda x: x[4:]),
            ("measured", self._read),
        ):
            self.DeclareVectorOutputPort(name, 4, _output(calc), prerequisites_of_calc=state)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._step)

    def _read(self, x: Any) -> Any:
        psi = np.zeros(4)
        simulation.read_encoders(x[:4], self.motor_map, self.home, self.lsb, psi)
        return psi

    def _step(self, context: Any, discrete_state: Any) -> None:
        x = context.get_discrete_state_vector().value()
        torque = self.GetInputPort("torque").Eval(context)
        held = np.clip(torque, -self.limit, self.limit)
        c = constants.from_vector(context.get_numeric_parameter(self.CONSTANTS).value())
        w, v = simulation.ode4_step(
            tuple(x[:4]),
            tuple(x[4:]),
            simulation.joint_forces(held, self.motor_map),
            self.period,
            c,
        )
        discrete_state.set_value(np.array([*w, *v]))


def _output(calc: Any) -> Any:
    def write(context: Any, output: Any) -> None:
        output.SetFromVector(calc(context.get_discrete_state_vector().value()))

    return write


@TemplateSystem.define("Carrier_")
def Carrier_(T: Any) -> Any:
    """The template of :class:`Carrier`."""

    class Impl(LeafSystem_[T]):
        r"""Closed-form robot in continuous time, for float, AutoDiffXd and Expression.

        :math:`M(w) w'' + c(w, w') = T^T \tau`, see ``models.pmc.dynamics``.

        | port | size | unit |
        |---|---|---|
        | in  `torque` | 4 | N m, motors (L1, R1, L2, R2) |
        | out `state`  | 8 | d1, d2, theta1, theta2 [m, rad] and their rates |

        Continuous state: joints and rates. Numeric parameter ``CONSTANTS`` as in :class:`SampledCarrier`; no torque
        limit. Assumes the working mode; the derivative is NaN out of reach.
        """

        CONSTANTS = 0

        def _construct(self, parameters: PMCParameters, converter: Any = None) -> None:
            LeafSystem_[T].__init__(self, converter)
            self.parameters = parameters
            self.motor_map = constants.motor_map(parameters.drive.lead)
            values = constants.to_vector(constants.of(parameters))
            self.DeclareNumericParameter(BasicVector_[T]([T(value) for value in values]))
            self.DeclareContinuousState(4, 4, 0)
            self.DeclareVectorInputPort("torque", 4)
            self.DeclareVectorOutputPort(
                "state", 8, self._state, prerequisites_of_calc={self.xc_ticket()}
            )

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            Impl._construct(self, other.parameters, converter=converter)

        def _state(self, context: Any, output: Any) -> None:
            output.SetFromVector(context.get_continuous_state_vector().CopyToVector())

        def DoCalcTimeDerivatives(self, context: Any, derivatives: Any) -> None:
            """Drake's hook: rates and accelerations."""
            x = context.get_continuous_state_vector().CopyToVector()
            torque = self.GetInputPort("torque").Eval(context)
            values = context.get_numeric_parameter(self.CONSTANTS).CopyToVector()
            # Building an Expression can raise the processor's invalid flag, which numpy reports.
            with np.errstate(invalid="ignore"):
                acceleration = dynamics.acceleration(
                    tuple(x[:4]),
                    tuple(x[4:]),
                    simulation.joint_forces(torque, self.motor_map),
                    constants.from_vector(values),
                )
            derivatives.get_mutable_vector().SetFromVector([*x[4:], *acceleration])

    return Impl


Carrier = Carrier_[None]
