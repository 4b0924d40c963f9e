r"""Constants of the MM3A arm: lengths, masses, inertias, joint limits.

The thesis prints no length and no mass. The lengths follow from chapter 2: a fine step of
:math:`10^{-7}` rad moves the tip by 5 nm, so the tip is 50 mm from the axis of joint 1; the full piezo
stroke of :math:`4\times10^{-4}` rad moves it by 20 um about joint 1 and 15 um about joint 2, so it is
37.5 mm from the axis of joint 2. Read at mid-travel (6 mm) this gives ``shoulder`` 12.5 mm and
``forearm`` 31.5 mm. The masses are **chosen**, for about 30 g of moving arm and so that the gravity moment
about joint 2 grows 3.6-fold over the travel of joint 3, as the mean of the printed \|d_i\| does
(Fig. 5.6: 5.99 to 21.67 urad). Inertias are those of homogeneous bars of these masses.
"""

from collections import namedtuple
from dataclasses import astuple, dataclass, fields
from typing import Any

import numpy as np

STANDARD_GRAVITY = 9.81  # [m/s^2]


@dataclass(frozen=True, kw_only=True)
class Arm:
    """The three links; inertias are about the centre of mass, diagonal in the D-H frame of the link.

    Raises ValueError if a length, mass or inertia is not positive or a joint range is empty.
    """

    shoulder: float = 0.0125  # a_1, axis of joint 1 to axis of joint 2 [m]
    forearm: float = 0.0315  # l_2, axis of joint 2 to the retracted tip [m]
    centre_1: float = 0.0080  # r_1, axis of joint 1 to the centre of link 1 along x_1 [m]
    centre_2: float = 0.0002  # r_2, axis of joint 2 to the centre of link 2 along z_2 [m]
    centre_3: float = 0.0282  # r_3, centre of link 3 to the tip along z_3 [m]
    mass_1: float = 0.016  # [kg]
    mass_2: float = 0.012  # [kg]
    mass_3: float = 0.002  # [kg]
    inertia_1x: float = 8.0e-7  # [kg m^2]
    inertia_1y: float = 1.1e-6  # about the axis of joint 1 [kg m^2]
    inertia_1z: float = 9.0e-7  # [kg m^2]
    inertia_2x: float = 6.0e-7  # [kg m^2]
    inertia_2y: float = 6.5e-7  # about the axis of joint 2 [kg m^2]
    inertia_2z: float = 4.0e-7  # [kg m^2]
    inertia_3x: float = 3.5e-7  # [kg m^2]
    inertia_3y: float = 3.5e-7  # about the axis of joint 2 [kg m^2]
    inertia_3z: float = 4.0e-9  # [kg m^2]
    lower_1: float = -2.0 * np.pi / 3.0  # [rad]
    upper_1: float = 2.0 * np.pi / 3.0  # [rad]
    lower_2: float = -7.0 * np.pi / 6.0  # [rad]
    upper_2: float = np.pi / 6.0  # [rad]
    lower_3: float = 0.0  # [m]
    upper_3: float = 0.012  # [m]

    def __post_init__(self) -> None:
        for field in fields(self):
            value = float(getattr(self, field.name))
            object.__setattr__(self, field.name, value)
            limit = field.name.startswith(("lower", "upper"))
            if not np.isfinite(value) or (not limit and value <= 0.0):
                raise ValueError(
                    f"arm: {field.name} is {value}; expected a {'finite' if limit else 'positive'} "
                    "number in SI units"
                )
        for joint, (lower, upper) in enumerate(zip(self.lower, self.upper), start=1):
            if lower >= upper:
                raise ValueError(
                    f"arm: joint {joint} ranges from {lower} to {upper}; expected lower < upper"
                )
        for link in "123":
            x, y, z = (getattr(self, f"inertia_{link}{axis}") for axis in "xyz")
            if 2.0 * max(x, y, z) > x + y + z:
                raise ValueError(
                    f"arm: inertias of link {link} are {x}, {y}, {z}; no body has one above the sum "
                    "of the other two"
                )

    @property
    def lower(self) -> tuple[float, float, float]:
        """Lower joint limits [rad, rad, m]."""
        return self.lower_1, self.lower_2, self.lower_3

    @property
    def upper(self) -> tuple[float, float, float]:
        """Upper joint limits [rad, rad, m]."""
        return self.upper_1, self.upper_2, self.upper_3

    def constants(self) -> Any:
        """Take the same fields as a named tuple, which compiled kernels accept."""
        return ArmConstants(*astuple(self))


# Generated from the fields above so that they are listed once; mypy cannot follow that.
ArmConstants: Any = namedtuple("ArmConstants", [field.name for field in fields(Arm)])  # type: ignore[misc]


def gravity_in_base(theta: Any, psi: Any, gravity: Any = STANDARD_GRAVITY) -> tuple[Any, Any, Any]:
    """Gravity acceleration [m/s^2] in frame 0 of a base tilted by R_W0 = R_x(theta) R_y(psi).

    Section 4.1.1: first ``theta`` [rad] about the world's x, then ``psi`` [rad] about the new y; world z
    points up.
    """
    down = -gravity * np.cos(theta)
    return -down * np.sin(psi), -gravity * np.sin(theta), down * np.cos(psi)
