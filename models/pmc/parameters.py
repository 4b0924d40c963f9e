r"""Masses, friction and drives of the PepperMill-Carrier: the one place for what the thesis leaves out.

Printed (Friedlaender 2015): half the robot's moving mass, 3.279 kg (3.6), without the collars' ends; the
inertia of the C-drive with a test collar (5.2), whose steel middle has that mass and the radii (3.7); a
counterweight "of approximately the same mass as the PM" (5.2). Nothing else about mass is printed: the
fields marked *assumed* are plausible values for the parts described in section 3.3, chosen so that the
printed sum holds.

The motors' torque limit is not printed either. 640 N, the largest horizontal force of Appendix B, are
:math:`4\pi\tau/p_c` of one C-drive: 3.06 N m each, whatever the posture. (The 32 N vertically would be 2.4 N m at
the isotropic posture, :math:`4\tau/r`; the largest command recorded in C-drive tests is 3.42 N m, Table 5-8.)
"""

from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path

import numpy as np
import yaml

from ..c_drive import CDriveParameters
from ..yaml_mapping import read_yaml_mapping
from .geometry import Geometry

HALF_MASS = 3.279  # of the robot without the collars' ends [kg], eq. (3.6)
TEST_COLLAR_RADII = (0.0445, 0.030)  # outer and inner, steel middle part [m], eq. (3.7)
TEST_INERTIA = CDriveParameters()  # M of eq. (5.2)


@dataclass(frozen=True, kw_only=True)
class Counterweight:
    """Weight on a rope from the top of the PM over a pulley above the robot (section 5.2).

    ``mass`` 0 is the robot without it. Raises ValueError for a negative or infinite value.
    """

    mass: float = 2.358  # that of the PM [kg], "approximately the same" (5.2)
    pulley_inertia: float = 2.0e-5  # of a light pulley, assumed [kg m^2]
    pulley_radius: float = 0.03  # assumed [m]
    pulley_friction: float = 0.5  # dry friction of the rope over the pulley, assumed [N]
    friction_speed: float = 2.0e-3  # width of its smoothed sign [m/s]
    x: float = 0.299  # pulley over the middle of the strokes, assumed [m]
    y: float = 0.299  # [m]
    z: float = 1.000  # above drive 2 and the highest PM, assumed [m]
    rope_height: float = (
        0.320  # of the rope's end over the PM's centre: screw and stroke, assumed [m]
    )

    def __post_init__(self) -> None:
        _check(self, "counterweight", positive=("pulley_radius", "friction_speed"))


@dataclass(frozen=True, kw_only=True)
class PMCParameters:
    """Everything the equations of motion need; the defaults are the prototype.

    Raises ValueError for a negative mass, inertia or friction, or if the parts do not sum up to less than
    the printed mass of the robot.
    """

    geometry: Geometry = field(default_factory=Geometry)
    gravity: float = 9.81  # [m/s^2]
    # One limb: collar middle and fork, tubes, Hooke body, nut.
    proximal_mass: float = 1.45  # assumed [kg]
    proximal_centre: float = 0.06  # from the drive axis along the link, assumed [m]
    proximal_inertia: float = 0.010  # about its centre of mass, assumed [kg m^2]
    distal_mass: float = 0.25  # two carbon tubes with inserts, assumed [kg]
    distal_centre: float = 0.15  # from the elbow, by symmetry [m]
    distal_inertia: float = 0.0019  # about its centre of mass: m l^2/12 [kg m^2]
    hooke_mass: float = 0.15  # assumed [kg]
    nut_mass: float = 0.25  # ballnut of a 20 mm screw, assumed [kg]
    # PepperMill with gripper; its mass follows from the printed sum.
    # Assumed: two steel screws of 10 mm radius and 0.37 kg, a gripper of 0.5 kg and 25 mm radius.
    pepper_mill_inertia: float = 2.0e-4  # about its axis [kg m^2]
    payload: float = 0.0  # on the axis of the PM [kg]
    # Viscous friction of the passive joints, assumed; needle bearings preloaded by Belleville washers.
    elbow_damping: float = 0.1  # [N m s/rad]
    wrist_damping: float = 0.1  # [N m s/rad]
    screw_damping: float = 1.0e-4  # of each nut [N m s/rad]
    # C-drives.
    collar_end_mass: float = 2.0  # both ends, assumed: a radius of gyration of 40 mm follows [kg]
    drive: CDriveParameters = field(default_factory=CDriveParameters)  # lead and friction are used
    torque_limit: float = 3.06  # of each motor, see above [N m]
    encoder_bits: int = 13  # per turn, section 5.1.4
    counterweight: Counterweight = field(default_factory=Counterweight)

    def __post_init__(self) -> None:
        _check(self, "PMC", positive=("hooke_mass", "nut_mass", "torque_limit"))
        if self.pepper_mill_mass <= 0.0:
            raise ValueError(
                f"PMC: the limbs weigh {self.limb_mass} kg each; expected less than the printed half "
                f"mass of {HALF_MASS} kg, the rest of which is the PepperMill"
            )

    def heavier(self, error: float) -> "PMCParameters":
        """The same robot with limbs, PM and counterweight heavier by the share ``error``: a wrong model.

        The printed mass holds the sum of limbs and PM, so that the PM's own error goes into ``payload``.
        """
        if error == 0.0:
            return self
        factor = 1.0 + error
        names = ["proximal_mass", "distal_mass", "hooke_mass", "nut_mass", "proximal_inertia"]
        names += ["distal_inertia", "pepper_mill_inertia"]
        heavier = replace(self, **{name: factor * getattr(self, name) for name in names})
        mill = factor * (self.pepper_mill_mass + self.payload) - heavier.pepper_mill_mass
        weight = replace(self.counterweight, mass=factor * self.counterweight.mass)
        return replace(heavier, payload=mill, counterweight=weight)

    @property
    def limb_mass(self) -> float:
        """One limb without the collar's ends [kg]."""
        return self.proximal_mass + self.distal_mass + self.wrist_mass

    @property
    def wrist_mass(self) -> float:
        """Hooke body and nut, which translate together [kg]."""
        return self.hooke_mass + self.nut_mass

    @property
    def pepper_mill_mass(self) -> float:
        """What the limbs leave of the printed mass, eq. (3.6) [kg]."""
        return 2.0 * (HALF_MASS - self.limb_mass)

    @property
    def rotor_inertia(self) -> float:
        """I_h of one motor shaft and screw from (5.2) and (2.6a) [kg m^2]."""
        test_mass = HALF_MASS + self.collar_end_mass
        sliding = TEST_INERTIA.lead**2 * test_mass / (8.0 * np.pi**2)
        return TEST_INERTIA.m11 - TEST_INERTIA.m12 - sliding

    @property
    def collar_end_inertia(self) -> float:
        """Inertia of the collar's ends about the drive axis from (5.2) and (3.7) [kg m^2]."""
        collar = 2.0 * (TEST_INERTIA.m11 + TEST_INERTIA.m12 - self.rotor_inertia)
        return collar - 0.5 * HALF_MASS * sum(radius**2 for radius in TEST_COLLAR_RADII)

    @classmethod
    def load(cls, path: str | Path) -> "PMCParameters":
        """Parameters from a YAML file of these fields; a field left out keeps its default."""
        return cls.from_mapping(read_yaml_mapping(path), str(path))

    @classmethod
    def from_mapping(cls, values: dict, where: str) -> "PMCParameters":
        """Parameters from nested mappings; ValueError, beginning with ``where``, for an unknown key."""
        return _build(cls, values, where)

    def save(self, path: str | Path) -> None:
        """Write all fields as YAML."""
        Path(path).write_text(yaml.safe_dump(asdict(self), sort_keys=False))


_NESTED = {"geometry": Geometry, "drive": CDriveParameters, "counterweight": Counterweight}


def _build(cls: type, values: dict, where: str) -> "PMCParameters":
    if not isinstance(values, dict):
        raise ValueError(f"{where}: {values!r}; expected a mapping of keys to values")
    known = [item.name for item in fields(cls)]
    unknown = sorted(str(key) for key in values if key not in known)
    if unknown:
        raise ValueError(f"{where}: unknown key {unknown[0]!r}; expected one of {', '.join(known)}")
    nested = {
        name: _build(_NESTED[name], value, f"{where}: {name}")
        for name, value in values.items()
        if name in _NESTED
    }
    try:
        return cls(**(values | nested))
    except TypeError as error:
        raise ValueError(f"{where}: {error}; expected numbers") from None


def _check(parameters: object, what: str, positive: tuple[str, ...]) -> None:
    for item in fields(parameters):  # type: ignore[arg-type]
        value = getattr(parameters, item.name)
        if not isinstance(value, int | float):
            continue
        if not np.isfinite(value) or value < 0.0 or (item.name in positive and value == 0.0):
            wanted = "a positive number" if item.name in positive else "zero or more"
            raise ValueError(f"{what}: {item.name} is {value}; expected {wanted}")
