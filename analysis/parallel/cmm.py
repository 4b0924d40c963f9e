"""Measured motions of the 3-PRS prototype (Ruiz et al. 2016, Tables 2, 4, 5), typed in from the source.

Slider and platform motions by a coordinate measuring machine (CMM), beside the source's finite elements (FEM) and its
forward kinematics (FKP). Translations in micrometres, angles as degrees-minutes-seconds in the source, here in seconds.
"""

from typing import NamedTuple


class Row(NamedTuple):
    """One pose: sliders, then z, psi and theta by CMM, FEM and FKP."""

    sliders: tuple[float, float, float]  # [um]
    z: tuple[float, float, float]  # [um]
    psi: tuple[float, float, float]  # [arcsec]
    theta: tuple[float, float, float]  # [arcsec]


ROWS = (
    Row((1395, 1531, 1306), (1471, 1408, 1384), (467, 245, 539), (313, 33, 64)),
    Row((777, 685, 725), (714, 727, 722), (161, -45, -98), (16, -90, -203)),
    Row((-676, -494, -706), (-636, -624, -631), (-137, 233, 535), (-214, 95, 221)),
    Row((-1485, -1175, -1781), (-1437, -1478, -1511), (548, 665, 1566), (261, 6, 11)),
)

# Force of each actuator [N] and slider motion [mm] by finite elements (Table 2).
STIFFNESS = ((20.0, 0.935), (40.0, 1.899), (60.0, 2.865))

# Section 4, for z of +-2 mm and psi, theta of +-0.2 deg.
TRAVEL = (-2.15, 2.30)  # [mm]
ANGLES = {"revolute": 1.7, "bending_m": 1.9, "bending_n": 0.2, "torsion": 0.2}  # [deg]
