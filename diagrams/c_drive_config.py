"""Typed settings of a C-drive loop, read from YAML by Drake's ``yaml_load_typed``.

The dataclasses are mutable because Drake's loader fills them field by field; their values are checked
when the loop is built, by the dataclasses of ``models/`` whose defaults they share.
"""

from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path

import numpy as np

from ..models import c_drive_controllers as controllers
from ..models.c_drive import CDriveParameters, collar_pose
from ..models.fourier_motion import FourierMotion, load_motion
from ..models.motion import MotionProgram, c_drive_motion
from .typed_yaml import load_typed, read_text

PLANTS = ("sampled", "continuous")


@dataclass(kw_only=True)
class Machine:
    """The drive; see ``CDriveParameters``."""

    lead: float = CDriveParameters.lead  # [m/rev]
    m11: float = CDriveParameters.m11  # [kg m^2]
    m12: float = CDriveParameters.m12  # [kg m^2]
    beta: float = CDriveParameters.beta  # [N m s/rad]
    gamma: float = CDriveParameters.gamma  # [N m s/rad]
    delta: float = CDriveParameters.delta  # Coulomb friction of each motor [N m]
    eta: float = CDriveParameters.eta  # Coulomb friction of the collar [N m]
    sign_width: float = CDriveParameters.sign_width  # [rad/s]

    def parameters(self) -> CDriveParameters:
        """The machine as model parameters; ValueError for impossible ones."""
        return CDriveParameters(**vars(self))


@dataclass(kw_only=True)
class Amplifier:
    """Actuator of each motor; see ``TorqueAmplifier``."""

    delay: float = 0.0  # of the command [s]
    gain: float = 1.0  # torque delivered per torque commanded [-]
    limit: float | None = None  # largest torque magnitude [N m], none for no limit
    lag: float = 0.0  # time constant of the torque loop [s]


@dataclass(kw_only=True)
class Limits:
    """What the machine allows a motion file to ask for; the benchmark's own extremes by default."""

    lowest: float = -0.2  # of the collar's travel u, Table 5-2 [m]
    highest: float = 0.0  # of the collar's travel u; every run starts at 0 [m]
    speed: float = 183.3  # of each motor, translation at 2 Hz [rad/s]
    torque: float = 3.4247  # of each motor, the largest printed, Table 5-5 [N m]

    def refuse(self, motion: FourierMotion, lead: float) -> None:
        """Raise ValueError, naming the limit, for a motion outside travel or speed."""
        position, rate, _ = motion.sample(np.linspace(0.0, motion.period, 2000))
        travel = collar_pose(position, lead)[:, 0]
        slack = 1e-3 * (self.highest - self.lowest)  # rounding of files, not of machines
        if travel.min() < self.lowest - slack or travel.max() > self.highest + slack:
            raise ValueError(
                f"motion {motion.name!r} moves the collar from {travel.min():.4f} to "
                f"{travel.max():.4f} m; expected limits.lowest {self.lowest} to limits.highest "
                f"{self.highest} m"
            )
        if np.max(np.abs(rate)) > self.speed * 1.001:
            raise ValueError(
                f"motion {motion.name!r} reaches {np.max(np.abs(rate)):.1f} rad/s; expected at most "
                f"limits.speed, {self.speed} rad/s"
            )


@dataclass(kw_only=True)
class PD:
    """Joint-space PD; with ``ki`` the ideal PID (4.32)."""

    kp: float = controllers.PD.kp  # [N m/rad]
    kd: float = controllers.PD.kd  # [N m s/rad]
    ki: float = controllers.PD.ki  # [N m/(rad s)]
    cutoff: float = controllers.PD.cutoff  # [rad/s]

    def settings(self) -> controllers.PD:
        """The controller as model settings."""
        return controllers.PD(**vars(self))


@dataclass(kw_only=True)
class TaskSpacePD:
    """Task-space PD (4.37)."""

    kp_translation: float = controllers.TaskSpacePD.kp_translation  # [N m/rad]
    kp_rotation: float = controllers.TaskSpacePD.kp_rotation  # [N m/rad]
    kd_translation: float = controllers.TaskSpacePD.kd_translation  # [N m s/rad]
    kd_rotation: float = controllers.TaskSpacePD.kd_rotation  # [N m s/rad]
    cutoff: float = controllers.TaskSpacePD.cutoff  # [rad/s]

    def settings(self) -> controllers.TaskSpacePD:
        """The controller as model settings."""
        return controllers.TaskSpacePD(**vars(self))


@dataclass(kw_only=True)
class ComputedTorque:
    """Computed torque with observer and unit delay (4.33-4.35)."""

    kp: float = controllers.ComputedTorque.kp  # [1/s^2]
    kd: float = controllers.ComputedTorque.kd  # [1/s]
    cutoff: float = controllers.ComputedTorque.cutoff  # [rad/s]
    observer_pole: float = -600.0  # both poles of the observer [rad/s]
    friction_compensation: float = controllers.ComputedTorque.friction_compensation  # c [-]

    def settings(self) -> controllers.ComputedTorque:
        """The controller as model settings."""
        return controllers.ComputedTorque(
            kp=self.kp,
            kd=self.kd,
            cutoff=self.cutoff,
            poles=(self.observer_pole, self.observer_pole),
            friction_compensation=self.friction_compensation,
        )


@dataclass(kw_only=True)
class ResolvedAcceleration:
    """Resolved acceleration (section 4.6.4): computed torque with gains for each collar direction."""

    kp_translation: float = controllers.ComputedTorque.kp  # [1/s^2]
    kp_rotation: float = controllers.ComputedTorque.kp  # [1/s^2]
    kd_translation: float = controllers.ComputedTorque.kd  # [1/s]
    kd_rotation: float = controllers.ComputedTorque.kd  # [1/s]
    cutoff: float = controllers.ComputedTorque.cutoff  # [rad/s]
    observer_pole: float = -600.0  # both poles of the observer [rad/s]
    friction_compensation: float = controllers.ComputedTorque.friction_compensation  # c [-]

    def settings(self) -> controllers.ComputedTorque:
        """The controller as model settings."""
        return controllers.ComputedTorque(
            kp=self.kp_translation,
            kd=self.kd_translation,
            kp_rotation=self.kp_rotation,
            kd_rotation=self.kd_rotation,
            cutoff=self.cutoff,
            poles=(self.observer_pole, self.observer_pole),
            friction_compensation=self.friction_compensation,
        )


Controller = PD | TaskSpacePD | ComputedTorque | ResolvedAcceleration

# Short names of the command line.
CONTROLLERS: dict[str, type[Controller]] = {
    "pd": PD,
    "ts": TaskSpacePD,
    "ct": ComputedTorque,
    "ra": ResolvedAcceleration,
}


@dataclass(kw_only=True)
class CDriveLoopConfig:
    """One C-drive under one controller, on one motion.

    In YAML the controller carries the tag of its class: ``controller: !TaskSpacePD {kp_rotation: 90}``.
    """

    controller: Controller = field(default_factory=PD)
    motion: str = "helical"  # a motion of Table 5-2, or a motion file (.yaml) with its own period
    rate: float = 2.0  # cycles per second of a motion of Table 5-2 [Hz]
    cycles: int = 2
    sample_time: float = 1e-3  # of the controller [s]
    encoder_bits: int = 13  # per turn; 0 for an exact encoder
    model_error: float = 1.0  # factor on M and D in the controller's model; 1.05 in section 5.1.2
    plant: str = "sampled"  # or "continuous": Drake's integrator with a zero-order hold
    machine: Machine = field(default_factory=Machine)
    amplifier: Amplifier = field(default_factory=Amplifier)
    limits: Limits = field(default_factory=Limits)

    def check(self) -> None:
        """Raise ValueError, naming the key, for a value no loop can be built with."""
        for key in ("sample_time", "model_error"):
            if not 0.0 < getattr(self, key) < float("inf"):
                raise ValueError(f"{key} is {getattr(self, key)}; expected a positive number")
        if self.cycles < 1:
            raise ValueError(f"cycles is {self.cycles}; expected 1 or more")
        if self.encoder_bits < 0:
            raise ValueError(f"encoder_bits is {self.encoder_bits}; expected 0 or more")
        if self.plant not in PLANTS:
            raise ValueError(f"plant is {self.plant!r}; expected one of {', '.join(PLANTS)}")
        program = self.program()
        if isinstance(program, FourierMotion):
            self.limits.refuse(program, self.machine.lead)
        if program.rate * self.sample_time > 0.05:
            raise ValueError(
                f"rate is {program.rate} Hz at a sample_time of {self.sample_time} s; expected 20 or "
                "more samples a cycle"
            )
        for key, lowest in (("delay", 0.0), ("lag", 0.0)):
            value = getattr(self.amplifier, key)
            if not lowest <= value < float("inf"):
                raise ValueError(f"amplifier.{key} is {value}; expected zero or more seconds")
        if self.amplifier.limit is not None and not self.amplifier.limit > 0.0:
            raise ValueError(
                f"amplifier.limit is {self.amplifier.limit}; expected a positive torque [N m]"
            )
        self.machine.parameters()

    def program(self) -> MotionProgram | FourierMotion:
        """The motion; ValueError for an unknown name or file, or a rate that is not positive."""
        if self.motion.endswith((".yaml", ".yml")):
            motion = load_motion(self.motion)
            if motion.shafts != 2:
                raise ValueError(f"{self.motion} moves {motion.shafts} shafts; expected 2")
            return motion
        return c_drive_motion(self.motion, self.rate)

    def believed(self) -> CDriveParameters:
        """The drive as the controller believes it to be."""
        return self.machine.parameters().scaled_model(self.model_error)


def load_config(path: str | Path) -> CDriveLoopConfig:
    """Settings from a YAML file; a key left out keeps its default.

    Raises ValueError for an unknown key or tag, a value of another type or text that is not YAML.
    """
    text = read_text(path)
    try:
        return parse_config(text)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def parse_config(text: str) -> CDriveLoopConfig:
    """Settings from YAML text; errors as for ``load_config``."""
    return load_typed(text, CDriveLoopConfig(), _known_keys())


def _known_keys() -> str:
    sections = (CDriveLoopConfig, Machine, Amplifier, Limits, *CONTROLLERS.values())
    return "; ".join(f"{s.__name__}: {', '.join(s.__dataclass_fields__)}" for s in sections)


def example_config() -> str:
    """Text of the example file that comes with the package."""
    return (resources.files(__package__) / "c_drive_loop.yaml").read_text(encoding="utf-8")
