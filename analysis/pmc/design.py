r"""Other dimensions of the PepperMill-Carrier: more torque to turn the gripper, more workspace (chapter 6).

1. variables: link lengths r and l, half spacing :math:`b_0` of the drives, screw lead;
2. objectives: reachable volume, and the torque about the gripper that the motors can give anywhere in it,
   :math:`\tau_{max} / \max(\partial\tau/\partial M_\phi)`;
3. limits: the carriages' strokes and motors stay; the robot is not taller than the prototype from the lowest wrist of
   limb 1 to the highest point of limb 2; the industry's cycle fits on both diagonals; bounds below.

The Pareto front comes from weighted Chebyshev problems solved by differential evolution. Not modelled: interference,
stiffness, and the mass of longer links or thicker screws, all of which take something back.
"""

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, differential_evolution

from ...models.pmc import limits
from ...models.pmc.geometry import Geometry
from ...models.pmc.parameters import PMCParameters
from . import reach, transmission
from .workspace import centred_posture

Floats = NDArray[np.float64]
# Bounds of the search, assumed: a fork still clears the PM at the least spacing, and screws of 20 mm diameter are
# made with leads up to their doubled diameter.
BOUNDS = {
    "proximal": (0.20, 0.40),  # [m]
    "distal": (0.20, 0.40),  # [m]
    "spacing": (0.15, 0.30),  # [m]
    "lead": (0.005, 0.040),  # [m/rev]
}
WEIGHTS = (0.35, 0.45, 0.55, 0.65, 0.75, 0.85)
# Heights and positions a side at which a design is judged.
CELLS = 15


@dataclass(frozen=True, kw_only=True)
class Merit:
    """What a geometry achieves."""

    volume: float  # reachable [m^3]
    torque: float  # about the gripper, available everywhere [N m]
    height: float  # of the envelope [m]
    cycle_room: float  # height to spare for the 25 mm lift with half a turn, negative if it does not fit [m]


Front = list[tuple[Geometry, Merit]]


@dataclass(frozen=True, kw_only=True)
class DesignStudy:
    """Pareto fronts, by falling volume, and the prototype."""

    front: Front  # every variable free
    same_lead: Front  # with the prototype's screws
    prototype: Merit
    seed: int


def merit(geometry: Geometry, parameters: PMCParameters) -> Merit:
    """Objectives and constraints of a geometry. ValueError where its limbs have no limit postures."""
    c = reach.cell_centres(geometry, CELLS)
    low, high = reach.turning_surfaces(c[:, None], c, 0.0, geometry)
    share = np.linspace(0.0, 1.0, CELLS)
    z = low[..., None] + share * (high - low)[..., None]
    poses, joints = centred_posture(c[:, None, None], c[None, :, None], z, geometry)
    needed = transmission.turning_torque(poses, joints, geometry, parameters.drive.lead)
    safe = limits.elevation_limits(geometry)
    wrists = reach.wrist_ranges(c[:, None], c, geometry)
    top = max(geometry.proximal * np.sin(safe.safe_max), float(wrists.high2.max()))
    surfaces = reach.reachable_surfaces(c[:, None], c, geometry)
    return Merit(
        volume=reach.volume(surfaces, c, c),
        torque=float(parameters.torque_limit / np.nanmax(needed)),
        height=float(2.0 * geometry.spacing + top - wrists.low1.min()),
        cycle_room=_cycle_room(geometry),
    )


def optimise(parameters: PMCParameters, *, seed: int = 1, generations: int = 40) -> DesignStudy:
    """Front of designs that keep the prototype's height and strokes."""
    prototype = merit(parameters.geometry, parameters)
    same_screws = {name: bound for name, bound in BOUNDS.items() if name != "lead"}
    fronts = []
    for bounds in (BOUNDS, same_screws):
        found = [
            _best(weight, bounds, parameters, prototype, seed + i, generations)
            for i, weight in enumerate(WEIGHTS)
        ]
        front = [(g, m) for g, m in found if not any(_dominates(other, m) for _, other in found)]
        fronts.append(sorted(front, key=lambda item: -item[1].volume))
    return DesignStudy(front=fronts[0], same_lead=fronts[1], prototype=prototype, seed=seed)


def findings(result: DesignStudy) -> dict[str, Any]:
    """What ``design.json`` holds."""
    return {
        "bounds": BOUNDS,
        "seed": result.seed,
        "prototype": asdict(result.prototype),
        "front": [{"geometry": asdict(g), "merit": asdict(m)} for g, m in result.front],
        "front_with_same_lead": [
            {"geometry": asdict(g), "merit": asdict(m)} for g, m in result.same_lead
        ],
    }


def _best(
    weight: float,
    bounds: dict[str, tuple[float, float]],
    parameters: PMCParameters,
    prototype: Merit,
    seed: int,
    generations: int,
) -> tuple[Geometry, Merit]:
    """Largest smaller of the weighted gains over the prototype, penalised outside the limits."""

    def cost(v: Floats) -> float:
        try:
            m = merit(_geometry(v, bounds, parameters.geometry), parameters)
        except ValueError:
            return 10.0
        gains = weight * m.volume / prototype.volume, (1.0 - weight) * m.torque / prototype.torque
        if not np.isfinite(gains).all():
            return 10.0
        tall = max(m.height - prototype.height, 0.0) / prototype.height
        tight = max(-m.cycle_room, 0.0) / 0.025
        return float(-min(gains) - 1e-3 * sum(gains) + 50.0 * (tall + tight))

    found = differential_evolution(
        cost,
        Bounds(*np.transpose(list(bounds.values()))),
        seed=seed,
        popsize=8,
        maxiter=generations,
        tol=1e-6,
        polish=False,
    )
    geometry = _geometry(found.x, bounds, parameters.geometry)
    return geometry, merit(geometry, parameters)


def _cycle_room(geometry: Geometry) -> float:
    """Height left over on the tighter diagonal of the strokes for a lift of 25 mm with half a turn [m]."""
    middle = 0.5 * (geometry.carriage_min + geometry.carriage_max)
    along = middle + 0.150 / np.sqrt(2.0) * np.linspace(-1.0, 1.0, 31)
    rooms = []
    for y in (along, 2.0 * middle - along):
        low, high = reach.turning_surfaces(along, y, np.pi, geometry)
        rooms.append(float(np.min(high) - np.max(low)) - 0.025)
    room = min(rooms)
    return room if np.isfinite(room) else -1.0


def _geometry(v: Floats, bounds: dict[str, tuple[float, float]], base: Geometry) -> Geometry:
    return replace(base, **{name: float(value) for name, value in zip(bounds, v)})


def _dominates(a: Merit, b: Merit) -> bool:
    better = a.volume > b.volume or a.torque > b.torque
    return better and a.volume >= b.volume and a.torque >= b.torque
