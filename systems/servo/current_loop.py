"""Windings of the motors, and the sampled current loop around them."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import Gain

from ...models.dc_motor import DCMotor, current_gains, winding_rate
from .. import scalars
from .pi_loop import PILoop


class Winding(LeafSystem):
    r"""Equal windings, each :math:`L\, di/dt = V - R i - K_E \dot\theta`, (3.1) of Roldan.

    | port | size | unit |
    |---|---|---|
    | in  `voltage`    | n | V |
    | in  `motor_rate` | n | rad/s |
    | out `current`    | n | A |

    Continuous state: currents, zero at the start.
    """

    def __init__(self, motor: DCMotor, size: int) -> None:
        LeafSystem.__init__(self)
        self.motor = motor
        for name in ("voltage", "motor_rate"):
            self.DeclareVectorInputPort(name, size)
        self.DeclareContinuousState(size)
        self.DeclareVectorOutputPort(
            "current", size, self._current, prerequisites_of_calc={self.xc_ticket()}
        )

    def _current(self, context: Any, output: Any) -> None:
        output.SetFromVector(context.get_continuous_state_vector().CopyToVector())

    def DoCalcTimeDerivatives(self, context: Any, derivatives: Any) -> None:
        """Write the rates of the currents."""
        current = context.get_continuous_state_vector().CopyToVector()
        voltage, rate = (scalars.signal(self, context, name) for name in ("voltage", "motor_rate"))
        m = self.motor
        rates = winding_rate(current, voltage, rate, m.resistance, m.inductance, m.emf_constant)
        derivatives.get_mutable_vector().SetFromVector(rates)


def _motor() -> DCMotor:
    return DCMotor(resistance=2.0, inductance=10e-3, torque_constant=1.43, emf_constant=1.43)


@dataclass(frozen=True, kw_only=True)
class CurrentLoop:
    """Proportional and integral loop on the current of a winding, the innermost of a cascade (Roldan, section 3.3.1).

    The source prints no winding of any machine's motors, and not this loop: the defaults are chosen for the five-bar, of
    the size of a 400 V servo motor with the printed 1.43 N m/A. Other machines' motors have printed torque constants
    alone: 30.2 mN m/A (2-PRR, 3-PRS), 1.08 N m/A (RePlaLink), and the 2PRU-1PRS table not even that.
    """

    motor: DCMotor = field(default_factory=_motor)
    bandwidth: float = 2.0 * np.pi * 800.0  # [rad/s]
    period: float = 62.5e-6  # [s]
    voltage_limit: float = 560.0  # of the rectified mains [V]
    emf_share: float = (
        1.0  # of the back-EMF, fed forward; without it the winding's pole rejects it slowly
    )

    def build(self, size: int, per_motor: float = 1.0) -> Diagram:
        """Loop and windings of ``size`` motors whose joints move ``per_motor`` for each rad of theirs.

        Ports: in ``command`` [A] and ``joint_rate`` [rad/s or m/s], out ``current`` [A] and ``voltage`` [V].
        Raises ValueError for a bandwidth, period or voltage limit that is not positive.
        """
        kp, ki = current_gains(self.motor, self.bandwidth, self.period)
        builder = DiagramBuilder()
        loop = builder.AddNamedSystem(
            "loop", PILoop(size, period=self.period, kp=kp, ki=ki, limit=self.voltage_limit)
        )
        winding = builder.AddNamedSystem("winding", Winding(self.motor, size))
        gear = builder.AddNamedSystem("gear", Gain(1.0 / per_motor, size))
        builder.Connect(loop.GetOutputPort("output"), winding.GetInputPort("voltage"))
        builder.Connect(gear.get_output_port(), winding.GetInputPort("motor_rate"))
        emf = builder.AddNamedSystem("emf", Gain(self.emf_share * self.motor.emf_constant, size))
        builder.Connect(gear.get_output_port(), emf.get_input_port())
        builder.Connect(emf.get_output_port(), loop.GetInputPort("feedforward"))
        builder.Connect(winding.GetOutputPort("current"), loop.GetInputPort("measured"))
        builder.ExportInput(loop.GetInputPort("command"), "command")
        builder.ExportInput(gear.get_input_port(), "joint_rate")
        builder.ExportOutput(winding.GetOutputPort("current"), "current")
        builder.ExportOutput(loop.GetOutputPort("output"), "voltage")
        return builder.Build()

    def connect(self, builder: Any, command: Any, axes: Any, per_motor: float) -> Any:
        """Add ``build`` to a diagram, between a port of commands and the ``axes`` they drive; its port of currents."""
        drive = builder.AddNamedSystem("current_loop", self.build(command.size(), per_motor))
        builder.Connect(command, drive.GetInputPort("command"))
        builder.Connect(axes.GetOutputPort("rate"), drive.GetInputPort("joint_rate"))
        return drive.GetOutputPort("current")
