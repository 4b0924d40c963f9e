r"""A closed chain as a tree MultibodyPlant, projected on the motions that keep its closures shut.

With closure Jacobian J and driven rates u: :math:`v = N u + ..., J N = 0`, and
:math:`N^T (M \dot v + C v - \tau_g) = f`. The oracle of ``models.parallel``, which shares no equation with it, and
the way to treat any machine that has no closed form. Redundant closures are allowed.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
from pydrake.multibody.tree import (
    BallRpyJoint,
    FixedOffsetFrame,
    JacobianWrtVariable,
    PrismaticJoint,
    RevoluteJoint,
    RotationalInertia,
    SpatialInertia,
    default_model_instance,
)

from ..models.closure import Closure
from ..models.parallel.bodies import BodyMotion
from ..models.parallel.chain import Chain, Link
from . import closures

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Projection:
    """Equations of motion in the driven joints: force = matrix a + bias."""

    matrix: Floats  # (n, n)
    bias: Floats  # (n,)
    rank: int  # of the closure Jacobian
    rows: int  # of the closure Jacobian: 3 a ball, 6 a weld


def discrete_plant(chain: Chain, time_step: float) -> MultibodyPlant:
    """Finalised SAP plant of a chain with its closures as constraints; errors of closure are of order time_step squared."""
    plant = MultibodyPlant(time_step)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    for link in chain.links:
        _add(plant, link)
    closures.apply(plant, default_model_instance(), list(chain.closures))
    plant.mutable_gravity_field().set_gravity_vector(chain.gravity)
    plant.Finalize()
    return plant


class ClosedChain:
    """Projected plant of a chain."""

    def __init__(self, chain: Chain) -> None:
        self.chain, self.plant = chain, MultibodyPlant(0.0)
        for link in chain.links:
            _add(self.plant, link)
        self.plant.mutable_gravity_field().set_gravity_vector(chain.gravity)
        self.plant.Finalize()
        self.context = self.plant.CreateDefaultContext()
        self.driven = [self._joint(name).velocity_start() for name in chain.driven]
        self.passive = [i for i in range(self.plant.num_velocities()) if i not in self.driven]
        self._driven_positions = [self._joint(name).position_start() for name in chain.driven]

    def home(self) -> Floats:
        """Coordinates (num_positions,) of the plant near a closed posture."""
        out, start = np.zeros(self.plant.num_positions()), 0
        for link in self.chain.links:
            joint = self._joint(link.name)
            first, size = joint.position_start(), joint.num_positions()
            out[first : first + size] = self.chain.home[start : start + size]
            start += size
        return out

    def close(self, driven: ArrayLike, near: ArrayLike | None = None) -> Floats:
        """Coordinates that close all loops at driven positions (n,), followed from ``near`` (default: home).

        They are followed in pieces of at most 0.1 rad or m, to stay in the assembly of ``near``. Raises ValueError where
        the loops do not close.
        """
        target = np.asarray(driven, dtype=float)
        at = self.home() if near is None else np.array(near, dtype=float)
        start = at[self._driven_positions]
        pieces = max(1, int(np.ceil(np.abs(target - start).max() / 0.1)))
        for share in np.linspace(0.0, 1.0, pieces + 1)[1:]:
            at[self._driven_positions] = start + share * (target - start)
            at = self._shut(at)
        return at

    def project(self, coordinates: ArrayLike, rates: ArrayLike) -> Projection:
        """Equations at coordinates (num_positions,) of the plant and driven rates (n,)."""
        plant, context = self.plant, self.context
        n, drift, rows = self._constrain(coordinates, rates)
        mass = plant.CalcMassMatrix(context)
        load = plant.CalcBiasTerm(context) - plant.CalcGravityGeneralizedForces(context)
        return Projection(
            n.T @ mass @ n,
            n.T @ (mass @ drift + load),
            int(np.linalg.matrix_rank(rows)),
            rows.shape[0],
        )

    def motion(self, coordinates: ArrayLike, rates: ArrayLike) -> BodyMotion:
        """Motion of all links' frames, in their own axes and order, for the regressor of ``bodies``."""
        n, drift, _ = self._constrain(coordinates, rates)
        gravity = np.array(self.chain.gravity)
        jacobians, drifts, spins, pulls = [], [], [], []
        for link in self.chain.links:
            frame = self.plant.GetFrameByName(link.name)
            into = frame.CalcPoseInWorld(self.context).rotation().matrix().T
            whole = self._spatial(link.name, np.zeros(3))
            bias = self._spatial_bias(link.name, np.zeros(3)) + whole @ drift
            turn = [into @ part for part in np.split(whole @ n, 2)]
            rotational, translational = (into @ part for part in np.split(bias, 2))
            jacobians.append(np.vstack([turn[1], turn[0]]))
            drifts.append(np.concatenate([translational, rotational]))
            spins.append(turn[0] @ np.asarray(rates, dtype=float))
            pulls.append(into @ gravity)
        return BodyMotion(*(np.stack(part) for part in (jacobians, drifts, spins, pulls)))

    def gap(self) -> float:
        """Largest distance between the sides of a closure [m], at the last posture."""
        return float(max(np.abs(self._offset(c)).max() for c in self.chain.closures))

    def _constrain(self, coordinates: ArrayLike, rates: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """N, the drift of v and the closure Jacobian; sets the context's state."""
        plant, context = self.plant, self.context
        plant.SetPositions(context, np.asarray(coordinates, dtype=float))
        rows = self._rows()
        # Redundant rows leave singular values of rounding size.
        into_passive = -np.linalg.pinv(rows[:, self.passive], rcond=1e-10)
        n = np.zeros((plant.num_velocities(), len(self.driven)))
        n[self.driven] = np.eye(len(self.driven))
        n[self.passive] = into_passive @ rows[:, self.driven]
        plant.SetVelocities(context, n @ np.asarray(rates, dtype=float))
        drift = np.zeros(plant.num_velocities())
        drift[self.passive] = into_passive @ self._bias()
        return n, drift, rows

    def _shut(self, coordinates: Floats) -> Floats:
        plant, context = self.plant, self.context
        for _ in range(30):
            plant.SetPositions(context, coordinates)
            gap = np.concatenate([self._offset(c) for c in self.chain.closures])
            if np.abs(gap).max() < 1e-13:
                break
            step = np.zeros(plant.num_velocities())
            step[self.passive] = -np.linalg.pinv(self._rows()[:, self.passive], rcond=1e-10) @ gap
            coordinates = coordinates + plant.MapVelocityToQDot(context, step)
        if np.abs(gap).max() > 1e-11:
            raise ValueError(
                f"the loops of {self.chain.name} do not close at "
                f"{coordinates[self._driven_positions].tolist()}; expected positions within reach"
            )
        return coordinates

    def _offset(self, closure: Closure) -> Floats:
        a, b = (
            self.plant.EvalBodyPoseInWorld(self.context, self.plant.GetBodyByName(body))
            for body in (closure.body_a, closure.body_b)
        )
        apart = a @ np.array(closure.p_a) - b @ np.array(closure.p_b)
        if closure.type == "ball":
            return np.asarray(apart)
        turned = RollPitchYaw(a.rotation() @ b.rotation().inverse()).vector()
        return np.concatenate([turned, apart])

    def _rows(self) -> Floats:
        return np.vstack([self._difference(c, self._spatial) for c in self.chain.closures])

    def _bias(self) -> Floats:
        return np.concatenate(
            [self._difference(c, self._spatial_bias) for c in self.chain.closures]
        )

    def _difference(self, closure: Closure, of) -> Floats:  # type: ignore[no-untyped-def]
        between = of(closure.body_a, np.array(closure.p_a)) - of(
            closure.body_b, np.array(closure.p_b)
        )
        return np.asarray(between[3:] if closure.type == "ball" else between)

    def _spatial(self, body: str, point: Floats) -> Floats:
        world, frame = self.plant.world_frame(), self.plant.GetFrameByName(body)
        return np.asarray(
            self.plant.CalcJacobianSpatialVelocity(
                self.context, JacobianWrtVariable.kV, frame, point, world, world
            )
        )

    def _spatial_bias(self, body: str, point: Floats) -> Floats:
        world, frame = self.plant.world_frame(), self.plant.GetFrameByName(body)
        bias = self.plant.CalcBiasSpatialAcceleration(
            self.context, JacobianWrtVariable.kV, frame, point, world, world
        )
        return np.asarray(bias.get_coeffs())

    def _joint(self, name: str):  # type: ignore[no-untyped-def]
        return self.plant.GetJointByName(name)


def _add(plant: MultibodyPlant, link: Link) -> None:
    massive = link.mass > 0.0 or any(link.inertia)
    tensor = RotationalInertia(*link.inertia)
    inertia = (
        SpatialInertia.MakeFromCentralInertia(link.mass, np.array(link.centre), tensor)
        if massive
        else SpatialInertia.Zero()
    )
    body = plant.AddRigidBody(link.name, inertia)
    parent = plant.GetFrameByName(link.parent)
    frame = plant.AddFrame(
        FixedOffsetFrame(f"{link.name}_joint", parent, RigidTransform(np.array(link.at)))
    )
    if link.kind == "ball":
        plant.AddJoint(BallRpyJoint(link.name, frame, body.body_frame()))
        return
    kind = RevoluteJoint if link.kind == "revolute" else PrismaticJoint
    plant.AddJoint(kind(link.name, frame, body.body_frame(), np.array(link.axis)))
