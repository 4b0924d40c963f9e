"""Mechatronic model of the five-bar (Roldan, section 4.1, Figs. 4.6 and 4.7), on the shared ``servo_loop``.

    from pydrake.systems.analysis import Simulator
    from gapscope.diagrams.five_bar_loop import MOTIONS, FiveBarLoop, build

    diagram = build(FiveBarLoop(scheme="workspace"), MOTIONS["circle"])
    Simulator(diagram).AdvanceTo(1.0)

Two servo motors with 40:1 gears turn the cranks. The position loop runs on a computer of its own and asks the
drives for speeds; their current loop counts as instantaneous unless a ``current_loop`` is given.
"""

from dataclasses import dataclass, field

from ..models.parallel.machine import FiveBarMachine
from ..models.paths import Circle, Line, Path
from ..models.servo_axis import ServoAxis
from .servo_loop import PORTS, Coupling, Scheme, ServoLoop, build

__all__ = ["GAINS", "MOTIONS", "PORTS", "Coupling", "FiveBarLoop", "Scheme", "build"]


@dataclass(frozen=True, kw_only=True)
class FiveBarLoop(ServoLoop):
    """Settings; defaults are printed in section 4.1.3, except where marked.

    Feed-forward and both filters are drawn in Fig. 4.7, their sizes are not printed: no filters by default, and the share
    of feed-forward with which the X move leaves its path by the printed 22 mm (``gapscope compare 5r``).
    """

    machine: FiveBarMachine = field(default_factory=FiveBarMachine)
    axis: ServoAxis = field(default_factory=ServoAxis)  # Table 4.1
    position_gain: float = 19.2  # k_v [1/s]; 3.54 in the X move
    feedforward: float = 0.41  # assumed [-]
    velocity_kp: float = 0.14  # [A s/rad]
    velocity_ki: float = 11.45  # printed in A/rad: times the integral of the speed error
    position_period: float = 5e-3  # ts_pos of the model [s]; the machine has 20 ms
    velocity_period: float = 250e-6  # ts_vel [s]
    step: float = 125e-6  # dt [s]


HEIGHT = 0.9  # y of the X move; not printed [m]
CENTRE = (0.0, 0.8)  # of the circles; not printed [m]
ACCELERATION = 1.0  # of the X move, and taken for the circles, where none is printed [m/s^2]
MOTIONS: dict[str, Path] = {
    "x-move": Line(start=(-0.6, HEIGHT), end=(0.6, HEIGHT), feed=1.0, acceleration=ACCELERATION),
    "circle": Circle(centre=CENTRE, radius=0.2, turns=1.0, feed=0.628, acceleration=ACCELERATION),
    "fast-circle": Circle(
        centre=CENTRE, radius=0.2, turns=1.0, feed=1.256, acceleration=ACCELERATION
    ),
}
GAINS = {"x-move": 3.54, "circle": 19.2, "fast-circle": 19.2}  # k_v [1/s], printed
