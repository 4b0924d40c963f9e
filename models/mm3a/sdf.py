"""The MM3A as SDF text for Drake's MultibodyPlant, generated from the constants of ``arm.py``.

``mm3a.sdf`` beside this module is the text for the default arm. Link frames are the D-H frames of
Table A.1 at zero joints; the base link is frame 0, to be welded to the world with the tilt of section
4.1.1. Shapes are visual only.
"""

import numpy as np

from .arm import Arm


def sdf(arm: Arm) -> str:
    """SDF 1.9 model ``mm3a`` with joints joint_1, joint_2 (revolute) and joint_3 (prismatic)."""
    out = 0.006 + arm.upper_3
    links = (
        _link(
            "link_1",
            f"{arm.shoulder!r} 0 0 {np.pi / 2!r} 0 0",
            arm.mass_1,
            (arm.centre_1 - arm.shoulder, 0.0, 0.0),
            (arm.inertia_1x, arm.inertia_1y, arm.inertia_1z),
            _shape(
                "arm",
                (-arm.shoulder / 2, 0, 0),
                f"<box><size>{arm.shoulder!r} 0.008 0.009</size></box>",
            ),
        ),
        _link(
            "link_2",
            f"{arm.shoulder!r} 0 0 0 0 0",
            arm.mass_2,
            (0.0, 0.0, arm.centre_2),
            (arm.inertia_2x, arm.inertia_2y, arm.inertia_2z),
            _shape("motor", (0, 0, 0), "<box><size>0.010 0.013 0.020</size></box>"),
        ),
        _link(
            "link_3",
            f"{arm.shoulder!r} 0 {arm.forearm!r} 0 0 0",
            arm.mass_3,
            (0.0, 0.0, -arm.centre_3),
            (arm.inertia_3x, arm.inertia_3y, arm.inertia_3z),
            _shape("slider", (0, 0, -arm.forearm), _cylinder(0.002, 2 * out))
            + _shape(
                "needle",
                (0, 0, (out - arm.forearm) / 2),
                _cylinder(0.00025, arm.forearm - out),
            ),
        ),
    )
    joints = (
        _joint(1, "revolute", "base", "0 0 1", "base", arm.lower_1, arm.upper_1),
        _joint(2, "revolute", "link_1", "0 -1 0", "link_2", arm.lower_2, arm.upper_2),
        _joint(3, "prismatic", "link_2", "0 0 1", "link_3", arm.lower_3, arm.upper_3),
    )
    base = "    <link name='base'>\n{}    </link>\n".format(
        _shape("puck", (0, 0, -0.009), _cylinder(0.010, 0.008))
    )
    return (
        "<?xml version='1.0'?>\n<sdf version='1.9'>\n  <model name='mm3a'>\n"
        + base
        + "".join(links)
        + "".join(joints)
        + "  </model>\n</sdf>\n"
    )


def _link(
    name: str,
    pose: str,
    mass: float,
    centre: tuple[float, float, float],
    inertia: tuple[float, float, float],
    shapes: str,
) -> str:
    x, y, z = inertia
    at = " ".join(repr(float(value)) for value in centre)
    return f"""    <link name='{name}'>
      <pose relative_to='base'>{pose}</pose>
      <inertial>
        <pose>{at} 0 0 0</pose>
        <mass>{mass!r}</mass>
        <inertia>
          <ixx>{x!r}</ixx><iyy>{y!r}</iyy><izz>{z!r}</izz><ixy>0</ixy><ixz>0</ixz><iyz>0</iyz>
        </inertia>
      </inertial>
{shapes}    </link>
"""


def _joint(
    number: int, kind: str, parent: str, axis: str, placed_at: str, lower: float, upper: float
) -> str:
    return f"""    <joint name='joint_{number}' type='{kind}'>
      <parent>{parent}</parent>
      <child>link_{number}</child>
      <pose relative_to='{placed_at}'>0 0 0 0 0 0</pose>
      <axis>
        <xyz expressed_in='__model__'>{axis}</xyz>
        <limit><lower>{float(lower)!r}</lower><upper>{float(upper)!r}</upper></limit>
      </axis>
    </joint>
"""


def _shape(name: str, at: tuple[float, float, float], geometry: str) -> str:
    where = " ".join(repr(float(value)) for value in at)
    return (
        f"      <visual name='{name}'>\n        <pose>{where} 0 0 0</pose>\n"
        f"        <geometry>{geometry}</geometry>\n      </visual>\n"
    )


def _cylinder(radius: float, length: float) -> str:
    return f"<cylinder><radius>{radius!r}</radius><length>{float(length)!r}</length></cylinder>"
