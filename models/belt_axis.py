"""Belt-driven linear axis of the 2PRU-1PRS table (Roldan, section 4.2.2, Table 4.2; article, eqs. 20-23).

Motor RE-40, gearbox 15:1, coupling, guide with a belt. Two sets of values: the manufacturers', and those identified by
dividing J_1 by 1.56 and raising the Coulomb torque to 7.18e-2 N m. Seen from the motor, kg m^2, N m/rad, N m.

The belt's 70 mm/rev are printed for the same guide, ZLW-1040, in the 2-PRR (6.21); they put the resonance of TF_2 at
914 Hz, printed as about 900 Hz. Misprint: (22) of the article has a load of 2.27 kg, Table 1 one of 0.076 kg;
with 2.27 kg TF_2 would resonate at 725 Hz, so that the table's value stands in (4.34), the article's in (23) alone.
"""

from dataclasses import dataclass, replace
from math import pi

from .dc_motor import joint_per_motor
from .transmission import DriveTrain

FRICTION_LOAD = 2.27  # M_load in (23) of the article [kg]


@dataclass(frozen=True, kw_only=True)
class BeltAxis:
    """One axis; defaults are the manufacturers' values. Raises ValueError unless they are positive."""

    motor: float = 1.42e-5  # J_motor [kg m^2]
    gearbox: float = 1.4e-6  # J_gearbox, at the motor [kg m^2]
    coupling: float = 4.68e-6  # J_coupling, used at the motor as (4.33) does [kg m^2]
    guide: float = 4.524e-4  # J_guide, at the pulley [kg m^2]
    carriage: float = 0.076  # M [kg]
    gear_ratio: float = 15.0  # i_r
    lead: float = 0.07  # of the belt, p of the 2-PRR's equal guides (6.1.5) [m/rev]
    stiffness: float = 67.702  # k_t [N m/rad]
    damping: float = 3e-8  # c_t [N m s/rad]
    driving_share: float = 1.0  # of J_1 in motor + gearbox + coupling; identified: 1/1.56
    coulomb: float = (0.2 + 4.07e-2 * FRICTION_LOAD) / 15.0  # (23), at the motor [N m]
    torque_constant: float = 0.0302  # of a 24 V RE-40, not printed [N m/A]

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not value > 0.0:
                raise ValueError(f"{name} is {value}; expected a value above 0")

    @property
    def per_motor(self) -> float:
        """Carriage motion per motor angle (3.28) [m/rad]."""
        return joint_per_motor(self.gear_ratio, self.lead)

    @property
    def driving(self) -> float:
        """J_1 (4.33) [kg m^2]."""
        return self.driving_share * (self.motor + self.gearbox + self.coupling)

    @property
    def driven(self) -> float:
        """J_2 (4.34) [kg m^2]."""
        return self.guide / self.gear_ratio**2 + self.carriage * self.per_motor**2

    @property
    def train(self) -> DriveTrain:
        """Two inertias and the belt."""
        return DriveTrain(
            inertias=(self.driving, self.driven),
            stiffnesses=(self.stiffness,),
            dampings=(self.damping,),
        )

    @property
    def resonances(self) -> tuple[float, float]:
        """Resonance of TF_2, the load on a held motor, and of TF_1, the free train [Hz]."""
        held = (self.stiffness / self.driven) ** 0.5
        return held / (2.0 * pi), float(self.train.modes()[0][-1]) / (2.0 * pi)


MANUFACTURER = BeltAxis()
IDENTIFIED = replace(MANUFACTURER, driving_share=1.0 / 1.56, coulomb=7.18e-2)
