"""SDF 1.9 of a chain, with a YAML of its closures beside it: SDF has no tag for them.

The tree is cut as the chain says; the joint of a link ``name`` is ``name_joint``. ``systems.closures`` reads the YAML. Dry friction is written in the joint's
``dynamics`` element, which Drake ignores.
"""

from collections.abc import Mapping

import numpy as np
import yaml

from .chain import Chain, Link

JOINTS = {"revolute": "revolute", "prismatic": "prismatic", "ball": "ball"}


def sdf(
    chain: Chain,
    viscous: Mapping[str, float] | None = None,
    coulomb: Mapping[str, float] | None = None,
) -> str:
    """The chain as SDF text, in full precision; friction of driven joints by name [N s/m, N; N m s/rad, N m]."""
    places: dict[str, np.ndarray] = {"world": np.zeros(3)}
    parts = []
    for link in chain.links:
        places[link.name] = places[link.parent] + np.array(link.at)
        parts.append(_link(link, places[link.name]))
        slow, dry = ((table or {}).get(link.name, 0.0) for table in (viscous, coulomb))
        parts.append(_joint(link, slow, dry))
    body = "\n".join(parts)
    return f'<?xml version="1.0"?>\n<sdf version="1.9">\n<model name="{chain.name}">\n{body}\n</model>\n</sdf>\n'


def closures(chain: Chain) -> str:
    """The closures as YAML text that ``systems.closures.load`` reads."""
    entries = [
        {
            "type": c.type,
            "body_a": c.body_a,
            "body_b": c.body_b,
            "p_a": list(c.p_a),
            "p_b": list(c.p_b),
        }
        for c in chain.closures
    ]
    return yaml.safe_dump(entries, sort_keys=False)


def _link(link: Link, at: np.ndarray) -> str:
    xx, yy, zz, xy, xz, yz = link.inertia
    return (
        f'<link name="{link.name}"><pose>{_words(at)} 0 0 0</pose>\n'
        f"<inertial><pose>{_words(link.centre)} 0 0 0</pose><mass>{link.mass!r}</mass>"
        f"<inertia><ixx>{xx!r}</ixx><iyy>{yy!r}</iyy><izz>{zz!r}</izz>"
        f"<ixy>{xy!r}</ixy><ixz>{xz!r}</ixz><iyz>{yz!r}</iyz></inertia></inertial></link>"
    )


def _joint(link: Link, viscous: float, coulomb: float) -> str:
    head = (
        f'<joint name="{link.name}_joint" type="{JOINTS[link.kind]}">'
        f"<parent>{link.parent}</parent><child>{link.name}</child>"
    )
    if link.kind == "ball":
        return f"{head}</joint>"
    return (
        f"{head}<axis><xyz>{_words(link.axis)}</xyz><dynamics><damping>{float(viscous)!r}</damping>"
        f"<friction>{float(coulomb)!r}</friction></dynamics></axis></joint>"
    )


def _words(vector) -> str:  # type: ignore[no-untyped-def]
    return " ".join(repr(float(value)) for value in vector)
