"""SDF 1.9 of the PepperMill-Carrier as a tree, written from its parameters.

Link frames are parallel to W at the joints' zero: both limbs stretched out, limb 1 along +y and limb 2
along +z, the PM's centre in wrist 1. Joint coordinates are those of the package:

- ``d1``, ``d2``: prismatic along x and y, carriage positions from the origin
- ``theta1``, ``theta2``: revolute about x and y, drive angles
- ``elbow1``, ``elbow2``, ``hooke1``, ``hooke2``: revolute about the same axes
- ``lower_screw``: right-handed, PM in wrist 1, angle -phi; ``upper_screw``: left-handed, nut 2 on the PM

The tree is cut between Hooke body 2 (link ``wrist2``) and its nut (link ``nut2``); ``closures.yaml`` welds
them. The rotors of the C-drives are reflected inertia of the driven joints. Only inertias about the axes that the
mechanism can turn about enter the dynamics; the others are shaped like a slender rod.
"""

from dataclasses import dataclass

from .constants import of
from .parameters import PMCParameters

# Hooke bodies and nuts never turn: their inertia [kg m^2] leaves the dynamics alone. As large as this, SAP makes the
# weld in a screw joint as stiff for translation as for rotation.
NOT_TURNING = (0.05, 0.05, 0.05)

STEEL, CARBON, GOLD = "0.6 0.62 0.65 1", "0.15 0.15 0.17 1", "0.90 0.62 0 1"
BLUE, ORANGE = "0 0.45 0.70 1", "0.84 0.37 0 1"


def sdf(parameters: PMCParameters) -> str:
    """The model as SDF text; its numbers are those of ``parameters``, written in full precision."""
    p = parameters
    r, rod, b0 = p.geometry.proximal, p.geometry.distal, p.geometry.spacing
    parts = [_base(p)]
    for limb in (_Limb(1, "1 0 0", (0.0, 1.0, 0.0), -b0), _Limb(2, "0 1 0", (0.0, 0.0, 1.0), b0)):
        parts += _limb(limb, p)
    parts += [
        _link(
            "pepper_mill",
            (0.0, r + rod, -b0),
            p.pepper_mill_mass + p.payload,
            (0.0, 0.0, 0.0),
            (0.1, 0.1, p.pepper_mill_inertia),
            _mill_visuals(b0),
        ),
        _link("nut2", (0.0, r + rod, -b0), p.nut_mass, (0, 0, 0), NOT_TURNING, ""),
        _screw("lower_screw", "wrist1", "pepper_mill", p.geometry.lead, p.screw_damping),
        _screw("upper_screw", "pepper_mill", "nut2", -p.geometry.lead, p.screw_damping),
    ]
    body = "\n".join(parts)
    return f'<?xml version="1.0"?>\n<sdf version="1.9" xmlns:drake="http://drake.mit.edu">\n<model name="pmc">\n{body}\n</model>\n</sdf>\n'


@dataclass(frozen=True)
class _Limb:
    number: int
    axis: str
    along: tuple[float, float, float]  # the stretched limb
    height: float  # of the drive axis

    def at(self, distance: float) -> tuple[float, ...]:
        x, y, z = (distance * value for value in self.along)
        return x, y, z + self.height


def _limb(limb: _Limb, p: PMCParameters) -> list[str]:
    c, n = of(p), limb.number
    r, rod = p.geometry.proximal, p.geometry.distal
    rotors = 2.0 * p.rotor_inertia
    mass = p.proximal_mass + p.collar_end_mass
    centre = c.crank_moment / mass
    crank = c.crank_inertia - rotors - mass * centre**2
    wrist = p.wrist_mass if n == 1 else p.hooke_mass
    link_colour = BLUE if n == 1 else ORANGE
    return [
        _link(f"carriage{n}", limb.at(0.0), 0.0, (0, 0, 0), (0.0,) * 3, ""),
        _link(
            f"proximal{n}",
            limb.at(0.0),
            mass,
            _scaled(limb, centre),
            _rod_inertia(limb, crank),
            _bar(limb, r, 0.022, link_colour) + _collar(limb),
        ),
        _link(
            f"distal{n}",
            limb.at(r),
            p.distal_mass,
            _scaled(limb, p.distal_centre),
            _rod_inertia(limb, p.distal_inertia),
            _bar(limb, rod, 0.012, CARBON),
        ),
        _link(f"wrist{n}", limb.at(r + rod), wrist, (0, 0, 0), NOT_TURNING, _ball(0.025)),
        _driven(
            f"d{n}",
            "prismatic",
            ("base", f"carriage{n}", limb.axis),
            damping=c.per_metre**2 * (2.0 * c.motor_viscous + 4.0 * c.collar_viscous),
            effort=2.0 * c.per_metre * p.torque_limit,
            rotor=rotors,
            gear=c.per_metre,
        ),
        _driven(
            f"theta{n}",
            "revolute",
            (f"carriage{n}", f"proximal{n}", limb.axis),
            damping=2.0 * c.motor_viscous,
            effort=2.0 * p.torque_limit,
            rotor=rotors,
            gear=1.0,
        ),
        _passive(f"elbow{n}", f"proximal{n}", f"distal{n}", limb.axis, p.elbow_damping),
        _passive(f"hooke{n}", f"distal{n}", f"wrist{n}", limb.axis, p.wrist_damping),
    ]


def _base(p: PMCParameters) -> str:
    g = p.geometry
    middle, length = 0.5 * (g.carriage_min + g.carriage_max), g.carriage_max - g.carriage_min + 0.3
    rails = _cylinder(
        "rail1", (middle, 0, -g.spacing), "0 1.5707963267948966 0", 0.012, length, STEEL
    )
    rails += _cylinder(
        "rail2", (0, middle, g.spacing), "1.5707963267948966 0 0", 0.012, length, STEEL
    )
    return _link("base", (0, 0, 0), 1.0, (0, 0, 0), (1.0,) * 3, rails) + (
        '\n<joint name="ground" type="fixed"><parent>world</parent><child>base</child></joint>'
    )


def _scaled(limb: _Limb, distance: float) -> tuple[float, ...]:
    return tuple(distance * value for value in limb.along)


def _rod_inertia(limb: _Limb, across: float) -> tuple[float, ...]:
    return tuple(0.1 * across if value else across for value in limb.along)


def _link(
    name: str,
    at: tuple[float, ...],
    mass: float,
    centre: tuple[float, ...],
    inertia: tuple[float, ...],
    visuals: str,
) -> str:
    moments = "".join(f"<{k}>{v!r}</{k}>" for k, v in zip(("ixx", "iyy", "izz"), inertia))
    return (
        f'<link name="{name}"><pose>{_triple(at)} 0 0 0</pose>\n'
        f"<inertial><pose>{_triple(centre)} 0 0 0</pose><mass>{mass!r}</mass>"
        f"<inertia>{moments}<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>"
        f"{visuals}</link>"
    )


def _driven(
    name: str,
    kind: str,
    place: tuple[str, str, str],
    *,
    damping: float,
    effort: float,
    rotor: float,
    gear: float,
) -> str:
    parent, child, axis = place
    return (
        f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>'
        f"<axis><xyz>{axis}</xyz><dynamics><damping>{damping!r}</damping></dynamics>"
        f"<limit><effort>{effort!r}</effort></limit></axis>"
        f"<drake:rotor_inertia>{rotor!r}</drake:rotor_inertia>"
        f"<drake:gear_ratio>{gear!r}</drake:gear_ratio></joint>"
    )


def _passive(name: str, parent: str, child: str, axis: str, damping: float) -> str:
    return (
        f'<joint name="{name}" type="revolute"><parent>{parent}</parent><child>{child}</child>'
        f"<axis><xyz>{axis}</xyz><dynamics><damping>{damping!r}</damping></dynamics>"
        "<limit><effort>0</effort></limit></axis></joint>"
    )


def _screw(name: str, parent: str, child: str, lead: float, damping: float) -> str:
    return (
        f'<joint name="{name}" type="screw"><parent>{parent}</parent><child>{child}</child>'
        f"<screw_thread_pitch>{lead!r}</screw_thread_pitch>"
        f"<axis><xyz>0 0 1</xyz><dynamics><damping>{damping!r}</damping></dynamics>"
        "<limit><effort>0</effort></limit></axis></joint>"
    )


def _mill_visuals(b0: float) -> str:
    half = 0.5 * b0
    return (
        _cylinder("lower", (0, 0, -b0), "0 0 0", 0.010, 0.16, STEEL)
        + _cylinder("upper", (0, 0, b0), "0 0 0", 0.010, 0.16, STEEL)
        + _cylinder("shaft", (0, 0, 0), "0 0 0", 0.014, 2.0 * b0 - 0.16, CARBON)
        + _cylinder("gripper", (0, 0, -b0 - 0.10), "0 0 0", 0.030, 0.04, GOLD)
        + _box("pointer", (0.05, 0, -b0 - 0.10), "0.10 0.015 0.015", GOLD)
        + _box("mark", (0.014, 0, half), "0.012 0.006 0.10", GOLD)
    )


def _bar(limb: _Limb, length: float, radius: float, colour: str) -> str:
    roll = "1.5707963267948966 0 0" if limb.along[1] else "0 0 0"
    return _cylinder("bar", _scaled(limb, 0.5 * length), roll, radius, length, colour)


def _collar(limb: _Limb) -> str:
    turn = "0 1.5707963267948966 0" if limb.number == 1 else "1.5707963267948966 0 0"
    return _cylinder("collar", (0, 0, 0), turn, 0.0445, 0.16, STEEL)


def _ball(radius: float) -> str:
    return _visual(
        "hooke", (0, 0, 0), "0 0 0", f"<sphere><radius>{radius!r}</radius></sphere>", STEEL
    )


def _cylinder(
    name: str, at: tuple[float, ...], turn: str, radius: float, length: float, colour: str
) -> str:
    shape = f"<cylinder><radius>{radius!r}</radius><length>{length!r}</length></cylinder>"
    return _visual(name, at, turn, shape, colour)


def _box(name: str, at: tuple[float, ...], size: str, colour: str) -> str:
    return _visual(name, at, "0 0 0", f"<box><size>{size}</size></box>", colour)


def _visual(name: str, at: tuple[float, ...], turn: str, shape: str, colour: str) -> str:
    return (
        f'\n<visual name="{name}"><pose>{_triple(at)} {turn}</pose><geometry>{shape}</geometry>'
        f"<material><diffuse>{colour}</diffuse></material></visual>"
    )


def _triple(values: tuple[float, ...]) -> str:
    return " ".join(repr(float(value)) for value in values)
