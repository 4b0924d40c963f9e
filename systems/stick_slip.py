"""The piezo stick-slip actuator in continuous time, its phases resolved by witness functions."""

from typing import Any

from pydrake.systems.framework import (
    BasicVector,
    EventStatus,
    LeafSystem,
    UnrestrictedUpdateEvent,
    WitnessFunctionDirection,
)

from ..models import stick_slip
from ..models.stick_slip import Actuator, Sawtooth, Segment

ZERO_CROSSING = WitnessFunctionDirection.kCrossesZero


class StickSlipActuator(LeafSystem):
    """Stack, friction contact and slider of ``models/stick_slip.py``, one sawtooth per period.

    x'' and y'' by its equations (1)-(3); the drive voltage is piecewise linear.

    | port | size | unit |
    |---|---|---|
    | in  `load`     | 1 | N, opposes positive motion |
    | out `position` | 1 | m, slider |
    | out `state`    | 8 | m, m/s, m, m/s, m, V, V, V: x, x', y, y', z, v_1, v_2, v_3 |
    | out `slipping` | 1 | 1 while the contact slips, 0 while it sticks |

    Continuous state of 8. Discrete state: voltage and slope of the present piece of the sawtooth and its
    start, switched by periodic events, and the phase of the contact, switched where the contact speed
    changes sign and where the bristle crosses its elastic limit or its sliding deflection. The
    integrator so never steps across a kink. Steps in ``direction`` -1 or 1 for ever; the load is assumed
    smooth within a step.
    """

    def __init__(
        self, actuator: Actuator | None = None, drive: Sawtooth | None = None, direction: int = 1
    ) -> None:
        super().__init__()
        if direction not in (-1, 1):
            raise ValueError(f"stick-slip actuator: direction is {direction}; expected -1 or 1")
        self._actuator = (actuator or Actuator()).constants()
        drive = drive or Sawtooth()
        self._load = self.DeclareVectorInputPort("load", BasicVector(1))
        state = self.DeclareContinuousState(stick_slip.STATES)
        self._drive = self.DeclareDiscreteState([0.0, 0.0, 0.0])  # voltage, slope, since
        self._phase = self.DeclareDiscreteState([0.0])
        self.DeclareVectorOutputPort("position", 1, self._calc_position, {self.xc_ticket()})
        self.DeclareStateOutputPort("state", state)
        self.DeclareStateOutputPort("slipping", self._phase)
        offset = 0.0
        for segment in drive.segments(direction):
            self.DeclarePeriodicDiscreteUpdateEvent(
                drive.period, offset, self._drive_update(segment)
            )
            offset += segment.duration
        phase_update = UnrestrictedUpdateEvent(self._update_phase)
        self._witnesses = [
            self.MakeWitnessFunction(
                name, WitnessFunctionDirection.kCrossesZero, function, phase_update
            )
            for name, function in (
                ("contact speed", self._contact_speed),
                ("elastic limit", self._beyond_elastic_limit),
                ("sliding deflection", self._beyond_sliding_deflection),
            )
        ]

    def DoGetWitnessFunctions(self, context: Any) -> Any:
        """Return the three functions whose zeros are the kinks of the contact law."""
        return self._witnesses

    def DoCalcTimeDerivatives(self, context: Any, derivatives: Any) -> None:
        """Evaluate equations (1)-(3) at the present piece of the sawtooth."""
        piece: Any = context.get_discrete_state(self._drive).value()
        voltage, slope, since = piece
        load: Any = self._load.Eval(context)
        rates = stick_slip.derivatives(
            context.get_continuous_state_vector().CopyToVector(),
            voltage + slope * (context.get_time() - since),
            slope,
            load[0],
            self._actuator,
        )
        derivatives.SetFromVector(rates)

    def _drive_update(self, segment: Segment) -> Any:
        def update(context: Any, discrete: Any) -> EventStatus:
            discrete.set_value(self._drive, [segment.start, segment.slope, context.get_time()])
            return EventStatus.Succeeded()

        return update

    def _update_phase(self, context: Any, _event: Any, state: Any) -> EventStatus:
        speed, deflection = self._contact(context)
        share = stick_slip.contact(speed, deflection, self._actuator)[2]
        state.get_mutable_discrete_state().set_value(self._phase, [1.0 if share > 0.0 else 0.0])
        return EventStatus.Succeeded()

    def _contact(self, context: Any) -> tuple[float, float]:
        _, dx, _, dy, z, *_ = context.get_continuous_state_vector().CopyToVector()
        return dx - dy, z

    def _contact_speed(self, context: Any) -> float:
        return self._contact(context)[0]

    def _beyond_elastic_limit(self, context: Any) -> float:
        speed, deflection = self._contact(context)
        return abs(deflection) - self._actuator.elastic_share * stick_slip.sliding_deflection(
            speed, self._actuator
        )

    def _beyond_sliding_deflection(self, context: Any) -> float:
        speed, deflection = self._contact(context)
        return abs(deflection) - stick_slip.sliding_deflection(speed, self._actuator)

    def _calc_position(self, context: Any, output: Any) -> None:
        output[0] = context.get_continuous_state_vector()[2]
