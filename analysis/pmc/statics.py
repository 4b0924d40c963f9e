r"""Can the motors hold the PepperMill-Carrier? With and without its counterweight (section 5.2).

Static motor torques are those of the inverse dynamics at rest, without friction. The masses are mostly assumed, so
the answer is given over a range of them, too: every assumed mass and lever drawn uniformly within a share of
its value, PM and counterweight following from the printed sum.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...models.pmc import constants, dynamics, kinematics
from ...models.pmc.parameters import Counterweight, PMCParameters
from . import reach
from .workspace import centred_posture

Floats = NDArray[np.float64]
ASSUMED = ("proximal_mass", "proximal_centre", "distal_mass", "hooke_mass", "nut_mass")
# What the sources allow as limit of a motor [N m], see ``models.pmc.parameters``.
PRINTED_LIMITS = (2.4, 3.06, 3.42)


@dataclass(frozen=True, kw_only=True)
class Holding:
    """Static torques with and without counterweight."""

    isotropic: dict[str, float]  # largest motor torque at the isotropic posture [N m]
    held_share: dict[str, dict[str, float]]  # of the workspace, by limit [N m]
    samples: int  # mass splits drawn
    spread: float  # share of the assumed values
    needs_counterweight: float  # share of splits: held with it, not without, isotropic posture
    seed: int


def static_torques(joints: Floats, parameters: PMCParameters) -> Floats:
    """Motor torques (..., 4) that hold the robot at joints (..., 4) [N m]."""
    w = tuple(np.moveaxis(joints, -1, 0))
    still = tuple(np.zeros_like(w[0]) for _ in range(4))
    force = dynamics.inverse_dynamics(w, still, still, constants.of(parameters))
    to_motors = constants.joint_map(parameters.drive.lead)
    return np.stack(np.broadcast_arrays(*force), axis=-1) @ to_motors


def holding(
    parameters: PMCParameters, *, samples: int = 1000, spread: float = 0.3, seed: int = 1
) -> Holding:
    """Whether the motors hold the robot, over the workspace and over plausible masses."""
    machines = {
        "with": parameters,
        "without": without_counterweight(parameters),
    }
    isotropic = _isotropic(parameters)
    postures = _workspace_postures(parameters)
    torques = {name: static_torques(postures, p) for name, p in machines.items()}
    return Holding(
        isotropic={name: _largest(isotropic, p) for name, p in machines.items()},
        held_share={
            name: {
                str(limit): float(np.mean(np.abs(torque).max(axis=-1) <= limit))
                for limit in (*PRINTED_LIMITS, parameters.torque_limit)
            }
            for name, torque in torques.items()
        },
        samples=samples,
        spread=spread,
        needs_counterweight=_share_that_needs_it(parameters, samples, spread, seed),
        seed=seed,
    )


def without_counterweight(parameters: PMCParameters) -> PMCParameters:
    """The same robot as first built."""
    return replace(parameters, counterweight=Counterweight(mass=0.0))


def _share_that_needs_it(p: PMCParameters, samples: int, spread: float, seed: int) -> float:
    rng = np.random.default_rng(seed)
    isotropic = _isotropic(p)
    needed = 0
    for _ in range(samples):
        factors = rng.uniform(1.0 - spread, 1.0 + spread, len(ASSUMED))
        changes: dict[str, Any] = {k: f * getattr(p, k) for k, f in zip(ASSUMED, factors)}
        drawn = replace(p, **changes)
        weight = replace(p.counterweight, mass=drawn.pepper_mill_mass)
        drawn = replace(drawn, counterweight=weight)
        held = _largest(isotropic, drawn) <= p.torque_limit
        needed += held and _largest(isotropic, without_counterweight(drawn)) > p.torque_limit
    return needed / samples


def _isotropic(p: PMCParameters) -> Floats:
    return kinematics.inverse(kinematics.isotropic_pose(p.geometry), p.geometry)


def _largest(joints: Floats, p: PMCParameters) -> float:
    return float(np.abs(static_torques(joints, p)).max())


def _workspace_postures(p: PMCParameters, n: int = 25) -> Floats:
    """Joints of the centred PM over the workspace (n, n, n, 4)."""
    c = reach.cell_centres(p.geometry, n)
    low, high = reach.turning_surfaces(c[:, None], c, 0.0, p.geometry)
    share = (np.arange(n) + 0.5) / n
    z = low[..., None] + share * (high - low)[..., None]
    return centred_posture(c[:, None, None], c[None, :, None], z, p.geometry)[1]
