"""Inverse and forward kinematics of a parallel machine as blocks of a diagram."""

from typing import Any

from pydrake.systems.framework import LeafSystem

from ...models.parallel.machine import ParallelMachine, joint_motion, joint_rate
from .. import scalars


class InverseKinematics(LeafSystem):
    r"""Joint motion of a motion of the task coordinates, the block IKP of Roldan's Fig. 3.12.

    .. math:: q = \mathrm{IKP}(x), \quad \dot q = J^{-1} \dot x, \quad
        \ddot q = J^{-1} (\ddot x - \dot J \dot q)

    | port | size | unit |
    |---|---|---|
    | in  `position`, `velocity`, `acceleration` | n | task coordinates, per s, per s^2 |
    | out `joint_position`     | n | rad or m |
    | out `joint_rate`         | n | rad/s or m/s |
    | out `joint_acceleration` | n | rad/s^2 or m/s^2 |

    No state. NaN out of reach. An output asks only for the inputs its equation has.
    """

    def __init__(self, machine: ParallelMachine) -> None:
        LeafSystem.__init__(self)
        self.machine, n = machine, len(machine.joints)
        for name in ("position", "velocity", "acceleration"):
            self.DeclareVectorInputPort(name, n)
        tickets = [self.GetInputPort(p).ticket() for p in ("position", "velocity", "acceleration")]
        outputs = {
            "joint_position": self._position,
            "joint_rate": self._rate,
            "joint_acceleration": self._acceleration,
        }
        for order, (name, calc) in enumerate(outputs.items()):
            self.DeclareVectorOutputPort(
                name, n, calc, prerequisites_of_calc=set(tickets[: order + 1])
            )

    def _position(self, context: Any, output: Any) -> None:
        output.SetFromVector(self.machine.inverse(scalars.signal(self, context, "position")))

    def _rate(self, context: Any, output: Any) -> None:
        x, v = (scalars.signal(self, context, name) for name in ("position", "velocity"))
        output.SetFromVector(joint_rate(self.machine, self.machine.inverse(x), v))

    def _acceleration(self, context: Any, output: Any) -> None:
        names = ("position", "velocity", "acceleration")
        x, v, a = (scalars.signal(self, context, name) for name in names)
        output.SetFromVector(joint_motion(self.machine, x, v, a)[2])


class ForwardKinematics(LeafSystem):
    """Task coordinates at joint coordinates, the block DKP of Roldan's Fig. 3.12.

    | port | size | unit |
    |---|---|---|
    | in  `joint_position` | n | rad or m |
    | out `position`       | n | task coordinates |

    No state. NaN where the loops do not close.
    """

    def __init__(self, machine: ParallelMachine) -> None:
        LeafSystem.__init__(self)
        self.machine, n = machine, len(machine.joints)
        self.DeclareVectorInputPort("joint_position", n)
        self.DeclareVectorOutputPort("position", n, self._position)

    def _position(self, context: Any, output: Any) -> None:
        output.SetFromVector(self.machine.forward(scalars.signal(self, context, "joint_position")))
