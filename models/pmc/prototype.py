r"""What the prototype of the PepperMill-Carrier showed beside the rigid model (Friedlaender 2015, 5.2.2).

1. joint compliance: elbow and wrist give way along the distal link by :math:`C_j N`, N its axial force;
   the wrist sinks by :math:`C_j F / \sin^2\beta` under a vertical load F;
2. link compliance: the proximal link and its collar bend across by :math:`C_l N \sin(\beta - \alpha)` at
   the elbow; the wrist sinks by :math:`C_l F (g/r)^2`;
3. calibration offset: the encoders' zero is off by :math:`\delta_i` in the drive angles, for the reference posture is set
   "by inspection"; the wrist is off by :math:`g_i \delta_i`;
4. unequal loading: F of the limbs differs by what turns the PM, by the rope and by inertia
   (``dynamics.wrist_loads``); the drives carry it with the unequal gains of Table 5-10, so that one sags further
   than the other (:func:`unequal_sag`).

Heights err by the mean of the wrists' errors, the rotation by their difference over 2p, which the fine screws
amplify. Quasi-static: the links' own vibration is faster than the cycles. Not modelled: pitch and roll of the PM.
"""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import constants, displacement, dynamics, kinematics
from .controllers import TaskSpacePD
from .parameters import PMCParameters
from .simulation import Run, settle

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class PrototypeEffects:
    """Magnitudes of (1)-(3); none is printed, the defaults are plausible. Raises ValueError if not finite."""

    joint_compliance: float = 2.0e-6  # C_j, two preloaded needle bearings in series [m/N]
    link_compliance: float = 4.0e-6  # C_l, fork, collar and ballscrews at the elbow [m/N]
    calibration1: float = 2.0e-3  # of drive 1, half a millimetre at the elbow [rad]
    calibration2: float = 0.0  # of drive 2 [rad]

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not np.isfinite(value) or (value < 0.0 and "compliance" in item.name):
                raise ValueError(
                    f"prototype effects: {item.name} is {value}; expected a real effect"
                )


def deflection(
    joints: Floats, loads: tuple[Any, Any], effects: PrototypeEffects, p: PMCParameters
) -> Floats:
    """Errors of z [m] and phi [rad], (..., 2), by (1) and (2) under vertical wrist loads [N]."""
    dim = p.geometry.dimensions
    w = tuple(np.moveaxis(joints, -1, 0))
    pose = displacement.pose(w, -1.0, -1.0, dim)
    alpha1, beta1, alpha2, beta2 = displacement.elevations(pose, w, dim)
    sink1 = loads[0] * _compliance(alpha1, beta1, effects)
    sink2 = loads[1] * _compliance(alpha2, beta2, effects)
    return np.stack([-0.5 * (sink1 + sink2), -0.5 * (sink1 - sink2) / dim.pitch], axis=-1)


def turning_compliance(
    poses: Floats, joints: Floats, effects: PrototypeEffects, p: PMCParameters
) -> Floats:
    """Rotation of the PM per torque about its axis, drives held, by (1) and (2) [rad/(N m)]."""
    dim = p.geometry.dimensions
    alpha1, beta1, alpha2, beta2 = displacement.elevations(
        tuple(np.moveaxis(poses, -1, 0)), tuple(np.moveaxis(joints, -1, 0)), dim
    )
    both = _compliance(alpha1, beta1, effects) + _compliance(alpha2, beta2, effects)
    return np.asarray(both / (2.0 * dim.pitch) ** 2)


def true_poses(run: Run, effects: PrototypeEffects) -> Floats:
    """Poses (samples, 4) of a run with compliance; calibration belongs into the run itself."""
    p = run.parameters
    c = constants.of(p)
    w, rates = tuple(run.joints.T), tuple(run.joint_rates.T)
    force = run.command @ constants.motor_map(p.drive.lead)
    second = dynamics.acceleration(w, rates, tuple(force.T), c)
    poses = run.poses
    poses[:, 2:] += deflection(run.joints, dynamics.wrist_loads(w, rates, second, c), effects, p)
    return poses


def unequal_sag(poses: Floats, p: PMCParameters) -> Floats:
    """By how much poses (n, 4) move at rest because drive 2 has half the gain of drive 1 (Table 5-10).

    Against the same task-space PD with the gains of drive 1 on both: motors under the weight that the counterweight
    leaves. Errors of z [m] and phi [rad] in the last two columns.
    """
    printed = TaskSpacePD()
    equal = replace(
        printed,
        kp_translation=(printed.kp_translation[0],) * 2,
        kp_rotation=(printed.kp_rotation[0],) * 2,
    )
    joints = kinematics.inverse(poses, p.geometry)
    rests = [
        np.array([settle(home, settings, p) for home in joints]) for settings in (printed, equal)
    ]
    uneven, even = (kinematics.forward(rest, p.geometry) for rest in rests)
    return np.asarray(uneven - even)


def _compliance(alpha: Any, beta: Any, effects: PrototypeEffects) -> Any:
    """Vertical compliance of a wrist [m/N]."""
    axial = 1.0 / np.sin(beta)
    across = np.sin(beta - alpha) * axial
    return effects.joint_compliance * axial * axial + effects.link_compliance * across * across
