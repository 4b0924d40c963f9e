"""Dimensions of the PepperMill-Carrier prototype (Friedlaender 2015, chapters 2 and 3)."""

from dataclasses import dataclass, fields

import numpy as np

from .displacement import Dimensions


@dataclass(frozen=True, kw_only=True)
class Geometry:
    """Dimensions and strokes; the defaults are the prototype.

    Raises ValueError if a length is not positive, a stroke is empty, or the margins are not acute.
    """

    proximal: float = 0.300  # r, length of the proximal links [m], eq. (3.1)
    distal: float = 0.300  # l, length of the distal links [m], eq. (3.1)
    spacing: float = 0.244  # b0, half the vertical distance of the C-drives [m], eq. (3.2)
    lead: float = 0.020  # of the PM screws [m/rev], eq. (3.4)
    carriage_min: float = 0.191  # least d_i [m], eq. (2.18)
    carriage_max: float = 0.407  # largest d_i [m], eq. (2.18)
    turns: float = 2.0  # rotation range of the PM [rev], eq. (2.21)
    distal_margin: float = np.pi / 6  # least slope of a distal link [rad], before (2.23)
    fold_margin: float = np.pi / 6  # least angle between the links of a limb [rad], eq. (2.25a)

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (np.isfinite(value) and value > 0.0):
                raise ValueError(
                    f"PMC geometry: {field.name} is {value}; expected a positive finite number"
                )
        if self.carriage_max <= self.carriage_min:
            raise ValueError(
                f"PMC geometry: carriage_max {self.carriage_max} m is not above carriage_min "
                f"{self.carriage_min} m; expected an interval"
            )
        for name in ("distal_margin", "fold_margin"):
            if getattr(self, name) >= np.pi / 2:
                raise ValueError(
                    f"PMC geometry: {name} is {getattr(self, name)} rad; expected less than pi/2"
                )

    @property
    def dimensions(self) -> Dimensions:
        """What the displacement laws need, for kernels."""
        return Dimensions(self.proximal, self.distal, self.spacing, self.pitch)

    @property
    def pitch(self) -> float:
        """Advance of the PM screws p [m/rad], eq. (3.4)."""
        return self.lead / (2.0 * np.pi)

    @property
    def centre_angle(self) -> float:
        """Screw angle phi of the centred PM [rad]: CP_i = b0 (3.5), hence -122 pi/5 (2.20a)."""
        return -self.spacing / self.pitch

    @property
    def angle_min(self) -> float:
        """Least screw angle [rad], -132 pi/5 in eq. (2.20b)."""
        return self.centre_angle - self.turns * np.pi

    @property
    def angle_max(self) -> float:
        """Largest screw angle [rad], -112 pi/5 in eq. (2.20b)."""
        return self.centre_angle + self.turns * np.pi
