"""Mechatronic model of the 2-PRR with parallelogram (Roldan, section 6.1), on the shared ``servo_loop``.

    from pydrake.systems.analysis import Simulator
    from gapscope.diagrams.two_prr_loop import MOTIONS, TwoPRRLoop, build

    diagram = build(TwoPRRLoop(scheme="computed-torque"), MOTIONS["pick-and-place"])
    Simulator(diagram).AdvanceTo(0.2)

Two RE-40 motors with 14:1 gears and belts of 70 mm/rev carry the sliders; the platform hangs between them and does not
turn. Table 6.2 counts the rotors in the sliders' masses: here they belong to the axes, so that the machine's load on an
axis is that of sliders, bars and platform alone. Gains are not printed for this machine: those of the 3-PRS, which has
the same motors, drives and computer, with a position gain for its larger travel.
"""

from dataclasses import dataclass, field, replace

from ..models.belt_axis import MANUFACTURER
from ..models.dc_motor import joint_per_motor
from ..models.parallel.machine import TwoPRRMachine
from ..models.parallel.two_prr import TwoPRR
from ..models.paths import Circle, Line, Path
from ..models.servo_axis import ServoAxis
from .servo_loop import PORTS, Coupling, Scheme, ServoLoop, build

__all__ = ["MOTIONS", "PORTS", "Coupling", "Scheme", "TwoPRRLoop", "build"]

PER_MOTOR = joint_per_motor(14.0, 0.07)  # printed (6.22) [m/rad]
COULOMB, VISCOUS = 43.3, 4.55  # means of both axes in Table 6.2 [N, N s/m]

AXIS = ServoAxis(
    inertia=MANUFACTURER.motor,
    viscous=VISCOUS * PER_MOTOR**2,
    coulomb=COULOMB * PER_MOTOR,
    sign_rate=1.0,  # chosen: sharp at the speeds of use, soft enough for the step [s/rad]
    torque_constant=0.0302,  # printed in 6.1.5 [N m/A]
    per_motor=PER_MOTOR,
)


def _machine() -> TwoPRRMachine:
    """The printed machine, without the rotors in its sliders."""
    printed = TwoPRR()
    one, two, *rest = printed.masses
    rotor = AXIS.joint_inertia
    return TwoPRRMachine(geometry=replace(printed, masses=(one - rotor, two - rotor, *rest)))


@dataclass(frozen=True, kw_only=True)
class TwoPRRLoop(ServoLoop):
    """Settings; what is not printed is marked."""

    machine: TwoPRRMachine = field(default_factory=_machine)
    axis: ServoAxis = AXIS
    position_gain: float = 20.0  # k_v, chosen [1/s]
    velocity_kp: float = 0.45  # half of the 3-PRS's, for a lighter rotor; chosen [A s/rad]
    velocity_ki: float = 9.0  # chosen [A/rad]
    position_period: float = 5e-3  # of the 3-PRS [s]
    velocity_period: float = 1e-3  # of the 3-PRS [s]
    step: float = 200e-6  # chosen [s]


# Inside the printed workspace, x in 0.40..0.86 m and y in -0.68..-0.41 m.
MOTIONS: dict[str, Path] = {
    "pick-and-place": Line(start=(0.5, -0.55), end=(0.8, -0.55), feed=0.4, acceleration=2.0),
    "circle": Circle(centre=(0.65, -0.55), radius=0.1, turns=1.0, feed=0.3, acceleration=2.0),
}
