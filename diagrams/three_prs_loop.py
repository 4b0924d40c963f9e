"""Mechatronic model of the compliant 3-PRS (Ruiz et al. 2016, section 6), on the shared ``servo_loop``.

    from pydrake.systems.analysis import Simulator
    from gapscope.diagrams.three_prs_loop import MOTIONS, ThreePRSLoop, build

    diagram = build(ThreePRSLoop(scheme="workspace"), MOTIONS["tilt"])
    Simulator(diagram).AdvanceTo(0.1)

Three RE-40 motors with 14:1 gears and belts push the legs inwards; flexures stand for joints, and what they pull is a load
of the axes that grows with the travel. Its position gain of 2.5 1/s is low: the speed loop's integral, printed as 0.001,
does next to nothing, so that dry friction of the guides keeps an error of many micrometres.
"""

from dataclasses import dataclass, field

from ..models.belt_axis import IDENTIFIED, MANUFACTURER
from ..models.dc_motor import joint_per_motor
from ..models.parallel.machine import TableMachine
from ..models.parallel.three_prs import FLEXURES, THREE_PRS
from ..models.paths import Path, Poses
from ..models.servo_axis import ServoAxis
from .servo_loop import PORTS, Coupling, Scheme, ServoLoop, build

__all__ = ["MOTIONS", "PORTS", "Coupling", "Scheme", "ThreePRSLoop", "build"]

AXIS = ServoAxis(
    inertia=MANUFACTURER.driving + MANUFACTURER.driven,  # of the table's axes, with nearly its gear
    viscous=0.0,  # none is printed [N m s/rad]
    coulomb=IDENTIFIED.coulomb,  # of the same guides on the 2PRU-1PRS table
    sign_rate=1.0,  # chosen: sharp at the speeds of use, soft enough for the step [s/rad]
    torque_constant=0.0302,  # printed [N m/A]
    per_motor=joint_per_motor(14.0, MANUFACTURER.lead),  # printed gear, belt as assumed there
)


def _machine() -> TableMachine:
    """The table on its flexures."""
    return TableMachine(table=THREE_PRS, flexures=FLEXURES)


@dataclass(frozen=True, kw_only=True)
class ThreePRSLoop(ServoLoop):
    """Settings; gains and sample times are printed, in units that leave room: 0.9 A rad^-1, 0.001 A s rad^-1."""

    machine: TableMachine = field(default_factory=_machine)
    axis: ServoAxis = AXIS
    position_gain: float = 2.5  # k_v [1/s]
    velocity_kp: float = 0.9  # read as A s/rad
    velocity_ki: float = 0.001  # read as A/rad
    position_period: float = 5e-3  # [s]
    velocity_period: float = 1e-3  # [s]
    step: float = 200e-6  # chosen [s]


HOME = THREE_PRS.home  # height of the level platform with all sliders at zero [m]
MOTIONS: dict[str, Path] = {
    "lift": Poses(start=(HOME, 0.0, 0.0), end=(HOME + 0.0015, 0.0, 0.0), duration=0.6),
    "tilt": Poses(start=(HOME, 0.0, 0.0), end=(HOME, 0.02, 0.01), duration=0.6),
}
