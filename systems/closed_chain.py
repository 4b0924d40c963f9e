r"""A closed chain as a tree MultibodyPlant, projected on the motions that keep its ball closures shut.

With closure Jacobian J and driven rates u: :math:`v = N u + ..., J N = 0`, and
:math:`N^T (M \dot v + C v - \tau_g) = f`. The oracle of ``models.parallel``: it shares no equation with it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    JacobianWrtVariable,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
    RotationalInertia,
    SpatialInertia,
)

from .closures import Closure

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Link:
    """A body on a joint at ``at`` of its parent; its frame lies in the joint, parallel to W at zero."""

    name: str
    parent: str  # "world" or an earlier link
    kind: str  # "revolute" about z or "prismatic" along x
    at: tuple[float, float] = (0.0, 0.0)  # in the parent's frame [m]
    mass: float = 0.0  # [kg]
    centre: float = 0.0  # along x of the link [m]
    inertia: float = 0.0  # about the centre, z [kg m^2]
    direction: float = 1.0  # sign of the joint coordinate


@dataclass(frozen=True)
class Projection:
    """Equations of motion in the driven joints: force = matrix a + bias."""

    matrix: Floats  # (n, n)
    bias: Floats  # (n,)
    rank: int  # of the closure Jacobian, three rows a closure


class ClosedChain:
    """Projected plant of planar links in x, y with gravity ``weight`` along -y [m/s^2]."""

    def __init__(
        self,
        links: Sequence[Link],
        closures: Sequence[Closure],
        driven: Sequence[str],
        weight: float,
    ) -> None:
        self.plant, self.closures = MultibodyPlant(0.0), tuple(closures)
        for link in links:
            _add(self.plant, link)
        self.plant.mutable_gravity_field().set_gravity_vector([0.0, -weight, 0.0])
        self.plant.Finalize()
        self.context = self.plant.CreateDefaultContext()
        self.driven = [self.plant.GetJointByName(name).velocity_start() for name in driven]
        self.passive = [i for i in range(self.plant.num_velocities()) if i not in self.driven]

    def project(self, coordinates: ArrayLike, rates: ArrayLike) -> Projection:
        """Equations at joint coordinates (num_positions,), in order of links, and driven rates (n,)."""
        plant, context = self.plant, self.context
        plant.SetPositions(context, np.asarray(coordinates, dtype=float))
        rows = self._rows()
        into_passive = -np.linalg.pinv(rows[:, self.passive])
        n = np.zeros((plant.num_velocities(), len(self.driven)))
        n[self.driven] = np.eye(len(self.driven))
        n[self.passive] = into_passive @ rows[:, self.driven]
        plant.SetVelocities(context, n @ np.asarray(rates, dtype=float))
        drift = np.zeros(plant.num_velocities())
        drift[self.passive] = into_passive @ self._bias()
        mass = plant.CalcMassMatrix(context)
        load = plant.CalcBiasTerm(context) - plant.CalcGravityGeneralizedForces(context)
        return Projection(
            n.T @ mass @ n, n.T @ (mass @ drift + load), int(np.linalg.matrix_rank(rows))
        )

    def gap(self) -> float:
        """Largest distance between the sides of a closure [m], at the last projected posture."""
        plant, gaps = self.plant, []
        for c in self.closures:
            a, b = (
                plant.EvalBodyPoseInWorld(self.context, plant.GetBodyByName(body)) @ np.array(p)
                for body, p in ((c.body_a, c.p_a), (c.body_b, c.p_b))
            )
            gaps.append(np.linalg.norm(a - b))
        return float(max(gaps))

    def _rows(self) -> Floats:
        return np.vstack(
            [self._row(c.body_a, c.p_a) - self._row(c.body_b, c.p_b) for c in self.closures]
        )

    def _bias(self) -> Floats:
        return np.concatenate(
            [self._drift(c.body_a, c.p_a) - self._drift(c.body_b, c.p_b) for c in self.closures]
        )

    def _row(self, body: str, point: tuple[float, float, float]) -> Floats:
        world, frame = self.plant.world_frame(), self.plant.GetFrameByName(body)
        kind, at = JacobianWrtVariable.kV, np.array(point)
        return np.asarray(
            self.plant.CalcJacobianTranslationalVelocity(
                self.context, kind, frame, at, world, world
            )
        )

    def _drift(self, body: str, point: tuple[float, float, float]) -> Floats:
        world, frame = self.plant.world_frame(), self.plant.GetFrameByName(body)
        kind, at = JacobianWrtVariable.kV, np.array(point)
        return np.asarray(
            self.plant.CalcBiasTranslationalAcceleration(
                self.context, kind, frame, at, world, world
            )
        ).ravel()


def _add(plant: MultibodyPlant, link: Link) -> RigidBody:
    centre = np.array([link.centre, 0.0, 0.0])
    # Only izz enters planar motion; the other moments make the inertia a valid one.
    moment = max(link.inertia, 1e-12)
    about_centre = RotationalInertia(moment, moment, moment)
    inertia = (
        SpatialInertia.MakeFromCentralInertia(link.mass, centre, about_centre)
        if link.mass > 0.0 or link.inertia > 0.0
        else SpatialInertia.Zero()
    )
    body = plant.AddRigidBody(link.name, inertia)
    parent = plant.GetFrameByName(link.parent)
    offset = RigidTransform([*link.at, 0.0])
    if link.kind == "revolute":
        axis = [0.0, 0.0, link.direction]
        joint = RevoluteJoint(
            link.name,
            plant.AddFrame(_offset_frame(link.name, parent, offset)),
            body.body_frame(),
            axis,
        )
    else:
        axis = [link.direction, 0.0, 0.0]
        joint = PrismaticJoint(
            link.name,
            plant.AddFrame(_offset_frame(link.name, parent, offset)),
            body.body_frame(),
            axis,
        )
    plant.AddJoint(joint)
    return body


def _offset_frame(name, parent, offset):  # type: ignore[no-untyped-def]
    from pydrake.multibody.tree import FixedOffsetFrame

    return FixedOffsetFrame(f"{name}_joint", parent, offset)
