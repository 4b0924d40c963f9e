"""Which motion of the PepperMill-Carrier do the prototype's flaws spoil, and where? (section 5.2.2)

The thesis saw translations without visible error and a poor rotation, worst in the central vertical region and best in
the upper part. Two answers: the gripper's errors on the industry cycle with each flaw, as shares of the motion
asked; and, statically over the height on the middle axis, how strongly a flaw turns the gripper. Errors of the drives,
their unequal sag and bending of the links turn it most at the isotropic height, in the middle, as observed; compliance
along the distal links, which the thesis suspects most, does not: there the links hang and carry their load best.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

from ...models.pmc import prototype, simulation
from ...models.pmc.controllers import CONTROLLERS
from ...models.pmc.cycle import IndustryCycle, Placement
from ...models.pmc.parameters import PMCParameters
from ...models.pmc.prototype import PrototypeEffects
from . import reach, transmission
from .workspace import centred_posture

Floats = NDArray[np.float64]
RIGID = PrototypeEffects(
    joint_compliance=0.0, link_compliance=0.0, calibration1=0.0, calibration2=0.0
)

SAG_EVERY = 20  # samples of the cycle between two poses whose sag is worked out


@dataclass(frozen=True, kw_only=True)
class Spoiled:
    """Largest change by one flaw on the industry cycle, each as share of the motion asked."""

    flaw: str
    across: float  # of 300 mm [-]
    up: float  # of 25 mm [-]
    rotation: float  # of half a turn [-]


@dataclass(frozen=True, kw_only=True)
class HeightProfile:
    """How strongly each flaw turns the gripper over the height of the middle axis, PM centred."""

    z: list[float]  # [m]
    per_drive_error: list[float]  # calibration and controller: rotation per drive angle [rad/rad]
    by_links: list[float]  # link compliance under a torque on the gripper [rad/(N m)]
    by_joints: list[float]  # joint compliance under a torque on the gripper [rad/(N m)]
    by_loading: list[float]  # unequal loading of drives of unequal gain, at rest [rad]

    def peak(self, name: str) -> float | None:
        """Height of the largest peak inside the profile that stands out by 1 % [m], None without one."""
        values = np.array(getattr(self, name))
        peaks, _ = find_peaks(values, prominence=0.01 * values.max())
        return self.z[int(peaks[np.argmax(values[peaks])])] if len(peaks) else None


@dataclass(frozen=True, kw_only=True)
class PrototypeStudy:
    """Findings about the prototype's flaws."""

    effects: PrototypeEffects
    spoiled: list[Spoiled]
    profile: HeightProfile


def study(
    parameters: PMCParameters, placement: Placement, effects: PrototypeEffects | None = None
) -> PrototypeStudy:
    """Both answers for one place of the cycle; resolved-acceleration control, the unequal sag at rest along the cycle."""
    effects = effects or PrototypeEffects()
    reference = simulation.sample_cycle(IndustryCycle(placement=placement), parameters)
    ideal = _poses(reference, RIGID, parameters)
    spoiled = [
        _share_of_motion(flaw, _poses(reference, values, parameters) - ideal)
        for flaw, values in _alone(effects).items()
    ]
    along = reference.poses[: len(reference.poses) // 2 : SAG_EVERY]
    spoiled.append(_share_of_motion("unequal_loading", prototype.unequal_sag(along, parameters)))
    return PrototypeStudy(
        effects=effects, spoiled=spoiled, profile=height_profile(parameters, effects)
    )


def height_profile(
    parameters: PMCParameters, effects: PrototypeEffects, n: int = 81
) -> HeightProfile:
    """Static sensitivities on the middle axis, over the heights that allow all turns."""
    g = parameters.geometry
    middle = 0.5 * (g.carriage_min + g.carriage_max)
    low, high = reach.turning_surfaces(middle, middle, 2.0 * np.pi * g.turns, g)
    z = np.linspace(float(low), float(high), n)
    poses, joints = centred_posture(np.array(middle), np.array(middle), z, g)
    flaws = _alone(effects)
    links, bearings = (
        prototype.turning_compliance(poses, joints, flaws[name], parameters).tolist()
        for name in ("link_compliance", "joint_compliance")
    )
    return HeightProfile(
        z=z.tolist(),
        per_drive_error=transmission.turning_error(poses, joints, g).tolist(),
        by_links=links,
        by_joints=bearings,
        by_loading=np.abs(prototype.unequal_sag(poses, parameters)[:, 3]).tolist(),
    )


def findings(result: PrototypeStudy) -> dict[str, Any]:
    """What goes into ``comparison.json``."""
    from dataclasses import asdict

    names = ("per_drive_error", "by_links", "by_joints", "by_loading")
    return {
        "effects": asdict(result.effects),
        "industry_cycle_shares": [asdict(row) for row in result.spoiled],
        "height_profile": asdict(result.profile),
        "peak_heights_m": {name: result.profile.peak(name) for name in names},
    }


def _share_of_motion(flaw: str, change: Floats) -> Spoiled:
    largest = np.abs(change).max(axis=0)
    return Spoiled(
        flaw=flaw,
        across=float(largest[:2].max() / 0.300),
        up=float(largest[2] / 0.025),
        rotation=float(largest[3] / np.pi),
    )


def _alone(effects: PrototypeEffects) -> dict[str, PrototypeEffects]:
    return {
        "joint_compliance": replace(RIGID, joint_compliance=effects.joint_compliance),
        "link_compliance": replace(RIGID, link_compliance=effects.link_compliance),
        "calibration": replace(
            RIGID, calibration1=effects.calibration1, calibration2=effects.calibration2
        ),
    }


def _poses(
    reference: simulation.Reference, effects: PrototypeEffects, parameters: PMCParameters
) -> Floats:
    run = simulation.run(
        reference,
        CONTROLLERS["ra"],
        parameters,
        calibration=(effects.calibration1, effects.calibration2),
    )
    return prototype.true_poses(run, effects)
