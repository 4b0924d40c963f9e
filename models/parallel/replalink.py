"""RePlaLink, a five-bar linkage whose tool lies beyond the joint of its rods (Roldan, section 6.2).

Masses and inertias are the theoretical column of Table 6.4. Lengths and centres of mass are not printed; the
coefficients of the base parameters (6.51)-(6.55) fix them: a crank's are r^2, and a rod with its centre a
share s from A to the end is (1-s) a + s d - s(1-s) l^2 in the squared end speeds a, d and the squared rate.
Hence cranks 0.45 m, rods 0.50 m, tool 0.80 m from A. The base distance is adjustable and not fixed so: assumed.
"""

from .five_bar import FiveBar

REPLALINK = FiveBar(
    base=0.3,  # assumed [m]
    crank1=0.45,
    rod2=0.5,
    rod3=0.5,
    crank4=0.45,
    tool=0.8,
    centres=(0.19005, 0.5178, 0.2161, 0.16849),
    masses=(3.215, 4.254, 1.890, 2.950, 0.4),
    inertias=(0.1257, 0.4062, 0.0783, 0.1060),
    rotors=(0.0041, 0.0041),
)
