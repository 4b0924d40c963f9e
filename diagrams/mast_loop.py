"""Mechatronic model of the 2PRU-1PRS table (Roldan, section 4.2, Figs. 4.17-4.19), on the shared ``servo_loop``.

    from pydrake.systems.analysis import Simulator
    from gapscope.diagrams.mast_loop import MOTIONS, MastLoop, build

    diagram = build(MastLoop(), MOTIONS["lift"])
    Simulator(diagram).AdvanceTo(0.1)

Three RE-40 motors with 15:1 gears and belts lift the legs. The axes are rigid here: their belts resonate near 900 Hz, far
above the 20 Hz of the table's use (4.2.3.1). They have the identified inertia and Coulomb torque; the controller, which
is not printed, is that of ``gapscope bandwidth mast``, tuned by the manufacturers' inertia.
"""

from dataclasses import dataclass, field

from ..models.belt_axis import IDENTIFIED, MANUFACTURER
from ..models.belt_control import Gains
from ..models.parallel import mast
from ..models.parallel.machine import TableMachine
from ..models.paths import Path, Poses
from ..models.servo_axis import ServoAxis
from .servo_loop import PORTS, Coupling, Scheme, ServoLoop, build

__all__ = ["MOTIONS", "PORTS", "Coupling", "MastLoop", "Scheme", "build"]

AXIS = ServoAxis(
    inertia=IDENTIFIED.driving + IDENTIFIED.driven,
    viscous=0.0,  # none is printed [N m s/rad]
    coulomb=IDENTIFIED.coulomb,
    sign_rate=1.0,  # chosen: sharp at the speeds of use, soft enough for the step [s/rad]
    torque_constant=IDENTIFIED.torque_constant,
    per_motor=IDENTIFIED.per_motor,
)
ASSUMED = Gains()
TUNED = ASSUMED.loops(MANUFACTURER)


@dataclass(frozen=True, kw_only=True)
class MastLoop(ServoLoop):
    """Settings; the controller is assumed."""

    machine: TableMachine = field(default_factory=TableMachine)
    axis: ServoAxis = AXIS
    position_gain: float = ASSUMED.position_gain
    velocity_kp: float = TUNED.velocity_kp
    velocity_ki: float = TUNED.velocity_ki
    position_period: float = ASSUMED.position_period
    velocity_period: float = ASSUMED.velocity_period
    step: float = 200e-6  # chosen [s]


HOME = mast.MAST.home  # height of the level platform with all sliders at zero [m]
MOTIONS: dict[str, Path] = {
    "lift": Poses(start=(HOME, 0.0, 0.0), end=(HOME + 0.02, 0.0, 0.0), duration=0.6),
    "psi": Poses(start=(HOME, 0.0, 0.0), end=(HOME, 0.1, 0.0), duration=0.6),
    "theta": Poses(start=(HOME, 0.0, 0.0), end=(HOME, 0.0, 0.1), duration=0.6),
}
