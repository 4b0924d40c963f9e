"""Constants of the equations of motion from the parameters of the PepperMill-Carrier."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..c_drive import collar_pose, motor_angles
from .displacement import Dimensions
from .dynamics import Constants
from .parameters import PMCParameters


def of(p: PMCParameters) -> Constants:
    """What ``dynamics`` needs; the rotors of a C-drive act on its carriage and on its angle alike."""
    rope = p.counterweight
    rotors = 2.0 * p.rotor_inertia
    per_metre = 2.0 * np.pi / p.drive.lead
    crank = p.proximal_inertia + p.proximal_mass * p.proximal_centre**2
    hanging = rope.mass > 0.0
    return Constants(
        dimensions=p.geometry.dimensions,
        gravity=p.gravity,
        axial_mass=p.limb_mass + p.collar_end_mass + rotors * per_metre**2,
        crank_inertia=crank + p.collar_end_inertia + rotors,
        crank_moment=p.proximal_mass * p.proximal_centre,
        rod_mass=p.distal_mass,
        rod_centre=p.distal_centre,
        rod_inertia=p.distal_inertia,
        wrist_mass=p.wrist_mass,
        mill_mass=p.pepper_mill_mass + p.payload,
        mill_inertia=p.pepper_mill_inertia,
        elbow_damping=p.elbow_damping,
        wrist_damping=p.wrist_damping,
        screw_damping=2.0 * p.screw_damping,
        rope_mass=(rope.mass + rope.pulley_inertia / rope.pulley_radius**2) * hanging,
        rope_weight=rope.mass * p.gravity,
        rope_friction=rope.pulley_friction * hanging,
        rope_friction_speed=rope.friction_speed,
        pulley_x=rope.x,
        pulley_y=rope.y,
        pulley_z=rope.z - rope.rope_height,
        per_metre=per_metre,
        motor_viscous=p.drive.beta,
        collar_viscous=0.5 * p.drive.gamma,
        motor_dry=p.drive.delta,
        collar_dry=p.drive.eta,
        dry_speed=p.drive.sign_width,
    )


def joint_map(lead: float) -> np.ndarray:
    """Joints (d1, d2, theta1, theta2) per motor angles (L1, R1, L2, R2), (4, 4), eq. (2.1)."""
    one = collar_pose(np.eye(2), lead).T
    return np.block(
        [[one[0], np.zeros(2)], [np.zeros(2), one[0]], [one[1], np.zeros(2)], [np.zeros(2), one[1]]]
    )


def motor_map(lead: float) -> np.ndarray:
    """Motor angles per joints, the inverse of :func:`joint_map`, eq. (2.4)."""
    one = motor_angles(np.eye(2), lead).T
    zero = np.zeros(2)
    return np.vstack(
        [
            np.column_stack([one[:, 0], zero, one[:, 1], zero]),
            np.column_stack([zero, one[:, 0], zero, one[:, 1]]),
        ]
    )


def to_vector(c: Constants) -> np.ndarray:
    """All constants as one vector, dimensions first."""
    return np.array([*c.dimensions, *c[1:]], dtype=float)


def from_vector(values: Sequence[Any]) -> Constants:
    """The constants that :func:`to_vector` flattened; entries may be AutoDiffXd or Expressions."""
    n = len(Dimensions._fields)
    return Constants(Dimensions(*values[:n]), *values[n:])
