"""Splitting a rigid machine into motor and load sides, for clearance and compliance."""

import numpy as np

from ....models.drive import (
    BACKWARD,
    BREAKAWAY,
    COUPLING_DAMPING,
    COUPLING_STIFFNESS,
    FORWARD,
    FROM_SHAFT,
    GAIN,
    GAP,
    LIMIT,
    LOAD_WIDTH,
    RIPPLE_WAVENUMBER,
    STAGES,
    STIFFNESS,
    TO_SHAFT,
    VISCOUS,
    VISCOUS_SKEW,
    Drive,
)
from ..drive_machine import DriveMachine, DrivePlant
from ..machine import Array, Parameter
from .base import parameter

FAMILY = "two inertias"
ON_LOAD = ", encoder on the load"  # in the name of a form
CONTACT = 3e4  # contact stiffness: the peak effort deflects it by 1/CONTACT of the travel
FORCES = [VISCOUS, VISCOUS_SKEW, FORWARD, BACKWARD, BREAKAWAY, STIFFNESS]  # scale with the friction
MOST_SHARE = 0.97
OTHER_SHARES = 0.75, 0.88, 1.12  # of the machine's own estimate, which is rarely printed
MOST_STEPS = 512  # of one sample
STEPS_PER_RADIAN = 1.2  # Runge-Kutta steps per radian of the fastest coupling mode
CONTACT_STEPS = (
    0.9  # as STEPS_PER_RADIAN, beside a clearance: the error of an impact falls slowly with more
)


def motor_share_parameter(machine: DriveMachine) -> Parameter:
    """Share of the smallest inertia on the motors' side, from the machine's own estimate."""
    own = machine.motor_share
    others = [part * own for part in OTHER_SHARES if part * own < MOST_SHARE]
    return parameter(
        "motor_share", "-", 0.3, lower=0.05, upper=MOST_SHARE, starts=(own,), seconds=others
    )


def split(
    plant: DrivePlant,
    machine: DriveMachine,
    *,
    share: float,
    stiffness: float,
    damping_ratio: float,
    gap: float | Array,
    dt: float,
    load_friction: float = 0.0,
    load_encoders: bool = False,
) -> None:
    """Put ``share`` of the smallest inertia on the motors' side of a coupling at every shaft.

    The encoders stay with the motors unless ``load_encoders``.
    ``gap`` is one clearance for all or one for each. Bearings stay with the motors; ``load_friction``
    is the share [-] of the friction of the other elements, or of all where there are bearings only,
    that moves to the load.
    """
    n = len(machine.joints)
    total = plant.inertia
    motor = share * float(np.linalg.eigvalsh(total)[0])
    load = total - motor * np.eye(n)
    plant.inertia = np.block([[motor * np.eye(n), np.zeros((n, n))], [np.zeros((n, n)), load]])
    d = plant.drive
    elements, element = _friction_of_both(d, n, load_friction)
    shaft = np.vstack([d.shaft, np.zeros_like(d.shaft)])
    shaft[n:, RIPPLE_WAVENUMBER] = shaft[n:, GAIN] = 1.0
    shaft[n:, LIMIT] = np.inf
    shaft[n:, STAGES] = 1.0
    shaft[n:, LOAD_WIDTH] = shaft[:n, LOAD_WIDTH]
    with np.errstate(invalid="ignore"):  # of a load with negative inertia, whose prediction fails
        fastest = np.sqrt(stiffness * (1.0 / motor + 1.0 / np.linalg.eigvalsh(load)[0]))
    coupling = np.zeros((n, 5))
    coupling[:, FROM_SHAFT] = np.arange(n)
    coupling[:, TO_SHAFT] = n + np.arange(n)
    coupling[:, COUPLING_STIFFNESS] = stiffness
    coupling[:, COUPLING_DAMPING] = 2.0 * damping_ratio * stiffness / fastest
    coupling[:, GAP] = gap
    plant.drive = d._replace(elements=elements, element=element, shaft=shaft, coupling=coupling)
    plant.first_sensed = n if load_encoders else 0
    steps = CONTACT_STEPS if np.any(gap) else STEPS_PER_RADIAN
    plant.substeps = max(plant.substeps, _few_sizes(fastest * dt * steps))


def _few_sizes(steps: float) -> int:
    """At least so many steps, one of 1, 2, 3, 4, 6, 8, 12, 16, 24...: plants of equal ones are predicted together."""
    # NaN makes 1: a plant with a negative inertia, whose prediction fails.
    steps = min(max(1.0, steps), MOST_STEPS)
    power = 2 ** int(np.floor(np.log2(steps)))
    return next(n for n in (power, 3 * power // 2, 2 * power) if n >= steps)


def _friction_of_both(drive: Drive, n: int, load_friction: float) -> tuple[Array, Array]:
    """Friction elements of motors and loads: their speeds (m, 2 n) per shaft speed, and constants."""
    motors = np.hstack([drive.elements, np.zeros_like(drive.elements)])
    if load_friction == 0.0:
        return motors, drive.element
    moved = slice(n if len(drive.element) > n else 0, None)
    kept, copies = drive.element.copy(), drive.element[moved].copy()
    copies[:, FORCES] *= load_friction
    kept[moved, FORCES] *= 1.0 - load_friction
    loads = np.hstack([np.zeros_like(drive.elements), drive.elements])[moved]
    return np.vstack([motors, loads]), np.vstack([kept, copies])
