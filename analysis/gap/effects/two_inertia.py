"""Splitting a rigid machine into motor and load sides, for clearance and compliance."""

import numpy as np

from ....models.drive import (
    COUPLING_DAMPING,
    COUPLING_STIFFNESS,
    FROM_SHAFT,
    GAIN,
    GAP,
    LIMIT,
    RIPPLE_WAVENUMBER,
    STAGES,
    TO_SHAFT,
)
from ..drive_machine import DriveMachine, DrivePlant
from ..machine import Array, Parameter
from .base import parameter

FAMILY = "two inertias"
CONTACT = 3e4  # contact stiffness: the peak effort deflects it by 1/CONTACT of the travel
STEPS_PER_RADIAN = 1.2  # Runge-Kutta steps per radian of the fastest coupling mode


def motor_share_parameter(machine: DriveMachine) -> Parameter:
    """Share of the smallest inertia on the motors' side, from the machine's own estimate."""
    return parameter("motor_share", "-", 0.3, lower=0.05, upper=0.97, starts=(machine.motor_share,))


def split(
    plant: DrivePlant,
    machine: DriveMachine,
    *,
    share: float,
    stiffness: float,
    damping_ratio: float,
    gap: float | Array,
    dt: float,
) -> None:
    """Put ``share`` of the smallest inertia on the motors' side of a coupling at every shaft.

    ``gap`` is one clearance for all or one for each.
    All friction stays with the motors, whose bearings and screw nuts make most of it.
    """
    n = len(machine.joints)
    total = plant.inertia
    motor = share * float(np.linalg.eigvalsh(total)[0])
    load = total - motor * np.eye(n)
    plant.inertia = np.block([[motor * np.eye(n), np.zeros((n, n))], [np.zeros((n, n)), load]])
    d = plant.drive
    elements = np.hstack([d.elements, np.zeros_like(d.elements)])
    shaft = np.vstack([d.shaft, np.zeros_like(d.shaft)])
    shaft[n:, RIPPLE_WAVENUMBER] = shaft[n:, GAIN] = 1.0
    shaft[n:, LIMIT] = np.inf
    shaft[n:, STAGES] = 1.0
    fastest = np.sqrt(stiffness * (1.0 / motor + 1.0 / float(np.linalg.eigvalsh(load)[0])))
    coupling = np.zeros((n, 5))
    coupling[:, FROM_SHAFT] = np.arange(n)
    coupling[:, TO_SHAFT] = n + np.arange(n)
    coupling[:, COUPLING_STIFFNESS] = stiffness
    coupling[:, COUPLING_DAMPING] = 2.0 * damping_ratio * stiffness / fastest
    coupling[:, GAP] = gap
    plant.drive = d._replace(elements=elements, shaft=shaft, coupling=coupling)
    plant.substeps = max(plant.substeps, int(np.ceil(fastest * dt * STEPS_PER_RADIAN)))
