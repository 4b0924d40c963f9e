"""The PepperMill-Carrier's control loop as a Diagram: source, controller, robot with encoders."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder

from ..models.pmc import cycle as cycles
from ..models.pmc import simulation
from ..models.pmc.controllers import CONTROLLERS, Settings, controller
from ..models.pmc.cycle import IndustryCycle, LameCycle, Placement
from ..models.pmc.parameters import PMCParameters
from ..systems.pmc_carrier import SampledCarrier
from ..systems.pmc_controller import CarrierController
from ..systems.pmc_source import PORTS, CycleSource
from .typed_yaml import load_typed, read_text

CYCLES = {"industry": IndustryCycle, "smooth": LameCycle}


@dataclass
class PlacementConfig:
    """Where the cycle is performed, as in ``models.pmc.cycle.Placement``; the best fit of the workspace study."""

    x: float = 0.299  # [m]
    y: float = 0.299  # [m]
    z: float = -0.2229  # [m]
    turn: float = 0.0  # middle of the turn from the PM's centred angle [rad]
    direction: float = 0.75 * np.pi  # [rad]


@dataclass
class PMCLoopConfig:
    """One closed loop. ``check`` raises ValueError for a name or number that no loop can be built with."""

    controller: str = "ts"
    cycle: str = "industry"
    speed: float = 1.0  # of the cycle, 1 is the printed 0.3 Hz [-]
    sample_time: float = 1e-3  # [s]
    model_error: float = 0.0  # of every mass in the controller's model, 0.05 is 5 % too heavy [-]
    parameters: str = ""  # YAML of PMCParameters, the prototype if empty
    placement: PlacementConfig = field(default_factory=PlacementConfig)

    @classmethod
    def load(cls, path: str | Path) -> "PMCLoopConfig":
        """Config from YAML; ValueError for text that is not, unknown keys and values of another type."""
        text, known = read_text(path), ", ".join(cls.__dataclass_fields__)
        try:
            return load_typed(text, cls(), known)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None

    def check(self) -> None:
        """Raise ValueError, naming the key, for what no loop can be built with."""
        for key, names in (("controller", CONTROLLERS), ("cycle", CYCLES)):
            if getattr(self, key) not in names:
                raise ValueError(
                    f"{key} is {getattr(self, key)!r}; expected one of {', '.join(names)}"
                )
        for key in ("speed", "sample_time"):
            value = getattr(self, key)
            if not 0.0 < value < np.inf:
                raise ValueError(f"{key} is {value}; expected a positive number")
        if not -0.5 < self.model_error < 1.0:
            raise ValueError(f"model_error is {self.model_error}; expected between -0.5 and 1")

    def machine(self) -> PMCParameters:
        """Parameters of the robot."""
        return PMCParameters.load(self.parameters) if self.parameters else PMCParameters()

    def settings(self) -> Settings:
        """Settings of the controller."""
        return CONTROLLERS[self.controller]

    def motion(self, machine: PMCParameters) -> IndustryCycle | LameCycle:
        """The cycle at its place."""
        p = self.placement
        place = Placement(
            x=p.x,
            y=p.y,
            z=p.z,
            phi=machine.geometry.centre_angle + p.turn,
            direction=p.direction,
        )
        if self.cycle == "smooth":
            return LameCycle(placement=place, time=LameCycle(placement=place).time / self.speed)
        printed = cycles.IndustryCycle(placement=place)
        return IndustryCycle(
            placement=place,
            lift_time=printed.lift_time / self.speed,
            travel_time=printed.travel_time / self.speed,
        )


def pmc_loop(config: PMCLoopConfig) -> Diagram:
    """Wire one loop of the PepperMill-Carrier; nothing is simulated yet.

    | port | size | unit |
    |---|---|---|
    | out `pose_reference` | 4 | m, m, m, rad |
    | out `joints`         | 4 | m, m, rad, rad |
    | out `rates`          | 4 | per s |
    | out `measured`       | 4 | rad, motors from home |
    | out `command`        | 4 | N m, motors (L1, R1, L2, R2) |

    Subsystems ``source``, ``controller`` and ``robot`` are found by name. The loop repeats
    ``models.pmc.simulation.run``. Raises ValueError for settings no loop can be built with, or a cycle out of reach.
    """
    config.check()
    dt, machine = config.sample_time, config.machine()
    motion = config.motion(machine)
    reference = simulation.sample_cycle(motion, machine, cycles=0.0, sample_time=dt)
    home = reference.joints[0]
    start = simulation.rest(reference, config.settings(), machine)
    believed = machine.heavier(config.model_error)
    builder = DiagramBuilder()
    source = builder.AddNamedSystem("source", CycleSource(motion, machine.geometry))
    law = builder.AddNamedSystem(
        "controller",
        CarrierController(controller(config.settings(), believed, home, dt), dt),
    )
    robot: Any = builder.AddNamedSystem("robot", SampledCarrier(machine, home, start, dt))
    for name in PORTS:
        builder.Connect(source.GetOutputPort(name), law.GetInputPort(name))
    builder.Connect(robot.GetOutputPort("measured"), law.GetInputPort("measured"))
    builder.Connect(law.GetOutputPort("torque"), robot.GetInputPort("torque"))
    for name, port in (
        ("pose_reference", source.GetOutputPort("pose")),
        ("joints", robot.GetOutputPort("joints")),
        ("rates", robot.GetOutputPort("rates")),
        ("measured", robot.GetOutputPort("measured")),
        ("command", law.GetOutputPort("torque")),
    ):
        builder.ExportOutput(port, name)
    diagram = builder.Build()
    diagram.set_name("pmc_loop")
    return diagram
