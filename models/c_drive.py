r"""The C-drive: two motors, two coaxial screws of opposite hand, one collar that slides and turns.

.. math:: M \ddot\psi + D \dot\psi + \phi_c = \tau

1. kinematics (2.1-2.4): :math:`w = (u, v) = J \psi`, :math:`v = p_c \theta / (2\pi)`;
2. dynamics (2.5-2.6) in motor angles :math:`\psi = (\psi_L, \psi_R)` [rad], torques [N m];
3. friction elements: the two motors, speeds :math:`\dot\psi_L, \dot\psi_R`, and the collar's nuts,
   speed :math:`\dot\psi_L - \dot\psi_R`, with viscous coefficients beta, beta, gamma/2 and Coulomb
   levels delta, delta, eta.

Not modelled here: motor electrics, shaft couplings, screw and collar elasticity, clearance.
Source: Friedlaender 2015, sections 2.1.1 and 5.1. Misprints and gaps (ERRATA): p in (2.3) is p_c;
the screw lead p_c and the damping matrix D are not printed (see the fields below).
"""

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import ArrayLike, NDArray

from .drive import BACKWARD, FORWARD, Drive, ideal_drive
from .yaml_mapping import read_yaml_mapping

SHAFTS = ("left", "right")
ELEMENTS = ("left", "right", "collar")
# Speeds of the friction elements from the motor speeds, eq. (2.6c).
ELEMENT_MAP = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, -1.0]])


@dataclass(frozen=True, kw_only=True)
class CDriveParameters:
    """Constants of the C-drive; the defaults are the prototype's test set-up.

    Raises ValueError if the lead is not positive, M is not positive definite, or a friction
    coefficient is negative or not finite.
    """

    lead: float = 0.060  # p_c [m/rev], fixed by Table 5-2: 200 mm for 20 pi/3 rad
    m11: float = 2.6312e-3  # generalized inertia, eq. (5.2) [kg m^2]
    m12: float = 1.8797e-3  # generalized inertia, eq. (5.2) [kg m^2]
    # Viscous friction is not printed; fitted once to the three PD torques of Table 5-4 (ERRATA).
    beta: float = 4.148e-3  # of each motor [N m s/rad]
    gamma: float = 2.792e-3  # of the collar [N m s/rad]
    delta: float = 0.0  # Coulomb friction of each motor [N m]
    eta: float = 0.0  # Coulomb friction of the collar [N m]
    sign_width: float = 0.5  # width of the smoothed sign of Coulomb friction [rad/s]

    def __post_init__(self) -> None:
        for name in ("lead", "m11", "sign_width"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name} is {getattr(self, name)}; expected a positive number")
        if not abs(self.m12) < self.m11:
            raise ValueError(
                f"m12 is {self.m12} with m11 = {self.m11}; expected |m12| < m11, or M is not "
                "positive definite"
            )
        for name in ("beta", "gamma", "delta", "eta"):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} is {getattr(self, name)}; expected zero or more")

    @classmethod
    def from_physical(
        cls,
        *,
        collar_mass: float,
        collar_inertia: float,
        rotor_inertia: float,
        lead: float = 0.060,
        **others: float,
    ) -> "CDriveParameters":
        """Eq. (2.6a): M from the collar's m [kg] and I_c [kg m^2] and the other parts' I_h [kg m^2].

        The lead [m/rev] turns the collar's mass into inertia; ``others`` are friction fields.
        """
        turning = collar_inertia / 4.0
        sliding = lead**2 * collar_mass / (16.0 * np.pi**2)
        return cls(
            lead=lead, m11=rotor_inertia + turning + sliding, m12=turning - sliding, **others
        )

    @classmethod
    def load(cls, path: str | Path) -> "CDriveParameters":
        """Parameters from a YAML file of these fields; a field left out keeps its default."""
        values = read_yaml_mapping(path)
        unknown = sorted(set(values) - set(cls.__dataclass_fields__))
        if unknown:
            raise ValueError(
                f"{path}: unknown key {unknown[0]!r}; expected {', '.join(cls.__dataclass_fields__)}"
            )
        try:
            return cls(**values)
        except TypeError as error:
            raise ValueError(f"{path}: {error}; expected numbers") from None

    def save(self, path: str | Path) -> None:
        """Write all fields as YAML."""
        Path(path).write_text(yaml.safe_dump(asdict(self), sort_keys=False))

    def scaled_model(self, factor: float) -> "CDriveParameters":
        """Same drive with M and D multiplied by ``factor``: the model error of section 5.1.2."""
        return replace(
            self,
            m11=factor * self.m11,
            m12=factor * self.m12,
            beta=factor * self.beta,
            gamma=factor * self.gamma,
        )


def jacobian(lead: float) -> NDArray[np.float64]:
    """J of eq. (2.1b) [m/rad]: collar displacements (u, v) per motor angles (L, R)."""
    return lead / (4.0 * np.pi) * np.array([[1.0, -1.0], [1.0, 1.0]])


def inverse_jacobian(lead: float) -> NDArray[np.float64]:
    """J^-1 of eq. (2.4) [rad/m]."""
    return 2.0 * np.pi / lead * np.array([[1.0, 1.0], [-1.0, 1.0]])


def collar_pose(psi: ArrayLike, lead: float) -> NDArray[np.float64]:
    """Collar translation u [m] and rotation theta [rad], (..., 2), from motor angles (..., 2) [rad]."""
    w = np.asarray(psi, dtype=float) @ jacobian(lead).T
    return w * np.array([1.0, 2.0 * np.pi / lead])


def motor_angles(pose: ArrayLike, lead: float) -> NDArray[np.float64]:
    """Motor angles (..., 2) [rad] that bring the collar to (u [m], theta [rad]), (..., 2)."""
    w = np.asarray(pose, dtype=float) * np.array([1.0, lead / (2.0 * np.pi)])
    return w @ inverse_jacobian(lead).T


def inertia_matrix(parameters: CDriveParameters) -> NDArray[np.float64]:
    """M of eq. (2.6a) [kg m^2]."""
    p = parameters
    return np.array([[p.m11, p.m12], [p.m12, p.m11]])


def damping_matrix(parameters: CDriveParameters) -> NDArray[np.float64]:
    """D of eq. (2.6b) [N m s/rad]."""
    return ELEMENT_MAP.T @ np.diag(_viscous(parameters)) @ ELEMENT_MAP


def drive(parameters: CDriveParameters) -> Drive:
    """The C-drive as an n-shaft drive: shafts ``SHAFTS``, friction elements ``ELEMENTS``."""
    p = parameters
    plant = ideal_drive(inertia_matrix(p), ELEMENT_MAP, _viscous(p), p.sign_width)
    plant.element[:, FORWARD] = plant.element[:, BACKWARD] = [p.delta, p.delta, p.eta]
    return plant


def _viscous(parameters: CDriveParameters) -> Any:
    return np.array([parameters.beta, parameters.beta, 0.5 * parameters.gamma])
