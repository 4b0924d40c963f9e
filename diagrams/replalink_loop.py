"""Mechatronic model of the RePlaLink (Roldan, section 6.2), on the shared ``servo_loop``.

    from pydrake.systems.analysis import Simulator
    from gapscope.diagrams.replalink_loop import MOTIONS, RePlaLinkLoop, build

    diagram = build(RePlaLinkLoop(scheme="computed-torque-workspace"), MOTIONS["circle"])
    Simulator(diagram).AdvanceTo(0.2)

Two B&R motors with 10:1 gears turn the cranks of a haptic device. Its links weigh several hundred times what the rotors
do at the cranks: the machine cannot stand in the diagram as a late disturbance of its axes (``gapscope compare
couplings``), and is one plant with them by default. No controller is printed: all gains are chosen.
"""

from dataclasses import dataclass, field, replace

from ..models.dc_motor import joint_per_motor
from ..models.parallel.machine import FiveBarMachine
from ..models.parallel.replalink import REPLALINK
from ..models.paths import Circle, Line, Path
from ..models.servo_axis import ServoAxis
from .servo_loop import PORTS, Coupling, Scheme, ServoLoop, build

__all__ = ["MOTIONS", "PORTS", "Coupling", "RePlaLinkLoop", "Scheme", "build"]

PER_MOTOR = joint_per_motor(10.0)  # printed (6.2.5)
COULOMB, VISCOUS = 0.551, 3.67  # means of both axes in Table 6.4 [N m, N m s/rad]

AXIS = ServoAxis(
    inertia=REPLALINK.rotors[0] * PER_MOTOR**2,  # I_6 of Table 6.4, which counts at the crank
    viscous=VISCOUS * PER_MOTOR**2,
    coulomb=COULOMB * PER_MOTOR,
    sign_rate=1.0,  # chosen: sharp at the speeds of use, soft enough for the step [s/rad]
    torque_constant=1.08,  # printed [N m/A]
    per_motor=PER_MOTOR,
)


def _machine() -> FiveBarMachine:
    """The printed linkage; its rotors belong to the axes here."""
    return FiveBarMachine(geometry=replace(REPLALINK, rotors=(0.0, 0.0)))


@dataclass(frozen=True, kw_only=True)
class RePlaLinkLoop(ServoLoop):
    """Settings; all gains are chosen, for some 1.6 kg m^2 at a crank."""

    machine: FiveBarMachine = field(default_factory=_machine)
    axis: ServoAxis = AXIS
    coupling: Coupling = Coupling.plant
    position_gain: float = 15.0  # k_v [1/s]
    velocity_kp: float = 2.0  # [A s/rad]
    velocity_ki: float = 40.0  # [A/rad]
    position_period: float = 1.2e-3  # of the control printed in 6.2.5 [s]
    velocity_period: float = 1.2e-3  # the same [s]
    step: float = 300e-6  # chosen [s]


MOTIONS: dict[str, Path] = {
    "line": Line(start=(0.0, 0.85), end=(0.2, 0.85), feed=0.5, acceleration=5.0),
    "circle": Circle(centre=(0.1, 0.85), radius=0.1, turns=1.0, feed=0.5, acceleration=5.0),
}
