"""The PepperMill-Carrier as a Drake MultibodyPlant: tree, discrete SAP plant with closure, projected tree.

Joint coordinates w = (d1, d2, theta1, theta2) as in ``models.pmc``. The counterweight is not in these plants.
"""

from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable, ModelInstanceIndex
from pydrake.systems.framework import Context

from ..models.pmc import description, kinematics
from ..models.pmc.geometry import Geometry
from ..models.pmc.parameters import PMCParameters
from . import closures

Floats = NDArray[np.float64]

DRIVEN = ("d1", "d2", "theta1", "theta2")
FOLDER = Path(str(files("gapscope.models") / "pmc"))


def add_pmc(
    plant: MultibodyPlant, parameters: PMCParameters, *, closed: bool
) -> ModelInstanceIndex:
    """Parse the robot into a plant that is not finalised; ``closed`` adds the loop closure (SAP only)."""
    text = description.sdf(parameters)
    (model,) = Parser(plant).AddModelsFromString(text, "sdf")
    if closed:
        closures.apply(plant, model, closures.load(FOLDER / "closures.yaml"))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -parameters.gravity])
    return model


def discrete_plant(
    parameters: PMCParameters, time_step: float, scene_graph: SceneGraph | None = None
) -> MultibodyPlant:
    """Finalised SAP plant with the loop closed by a weld; closure errors are of order time_step squared."""
    plant = MultibodyPlant(time_step)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    if scene_graph is not None:
        plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_pmc(plant, parameters, closed=True)
    plant.Finalize()
    return plant


def tree_positions(joints: ArrayLike, plant: MultibodyPlant, geometry: Geometry) -> Floats:
    """Positions (num_positions,) of the tree that close the loop at joints (4,), working branch."""
    w = np.asarray(joints, dtype=float)
    pose = kinematics.forward(w, geometry)
    alpha1, beta1, alpha2, beta2 = kinematics.link_elevations(pose, w, geometry)
    values = {
        **dict(zip(DRIVEN, w)),
        "elbow1": beta1 - alpha1,
        "hooke1": -beta1,
        "elbow2": alpha2 - beta2,
        "hooke2": beta2 - 0.5 * np.pi,
        "lower_screw": -pose[3],
        "upper_screw": pose[3],
    }
    q: Floats = np.zeros(plant.num_positions())
    for name, value in values.items():
        q[plant.GetJointByName(name).position_start()] = value
    return q


def closure_error(plant: MultibodyPlant, context: Context) -> float:
    """Distance between the two sides of the cut [m]."""
    a, b = (
        plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(name)).translation()
        for name in ("wrist2", "nut2")
    )
    return float(np.linalg.norm(a - b))


@dataclass(frozen=True)
class Projection:
    """Equations of motion of the closed loop from the tree, in the four driven joints."""

    matrix: Floats  # (4, 4) M
    bias: Floats  # (4,) c
    rank: int  # of the closure Jacobian (6, 10)

    def acceleration(self, force: ArrayLike) -> Floats:
        """Accelerations (4,) of the driven joints under their forces (4,)."""
        return np.asarray(np.linalg.solve(self.matrix, np.asarray(force) - self.bias))


class ProjectedPlant:
    r"""Continuous tree plant whose dynamics are projected on the motions that keep the loop closed.

    With closure Jacobian J (6, 10) and driven joints u: v = N u, J N = 0, and
    :math:`N^T (M \dot v + C v - \tau) = N^T B f`.
    """

    def __init__(self, parameters: PMCParameters) -> None:
        self.parameters = parameters
        self.plant = MultibodyPlant(0.0)
        add_pmc(self.plant, parameters, closed=False)
        self.plant.Finalize()
        self.context = self.plant.CreateDefaultContext()
        self.driven = [self.plant.GetJointByName(name).velocity_start() for name in DRIVEN]
        self.passive = [i for i in range(self.plant.num_velocities()) if i not in self.driven]
        self.damping = np.zeros(self.plant.num_velocities())
        for index in self.plant.GetJointIndices():
            joint = self.plant.get_joint(index)
            start, count = joint.velocity_start(), joint.num_velocities()
            self.damping[start : start + count] = joint.default_damping_vector()[:count]

    def project(self, joints: ArrayLike, rates: ArrayLike) -> Projection:
        """Projected equations at joints (4,) and rates (4,)."""
        plant, context = self.plant, self.context
        plant.SetPositions(context, tree_positions(joints, plant, self.parameters.geometry))
        jacobian = self._closure_jacobian()
        into_passive = -np.linalg.pinv(jacobian[:, self.passive])
        n = np.zeros((plant.num_velocities(), 4))
        n[self.driven] = np.eye(4)
        n[self.passive] = into_passive @ jacobian[:, self.driven]
        v = n @ np.asarray(rates, dtype=float)
        plant.SetVelocities(context, v)
        drift = np.zeros(plant.num_velocities())
        drift[self.passive] = into_passive @ self._closure_bias()
        mass = plant.CalcMassMatrix(context)
        load = (
            plant.CalcBiasTerm(context)
            - plant.CalcGravityGeneralizedForces(context)
            + self.damping * v
        )
        return Projection(
            n.T @ mass @ n, n.T @ (mass @ drift + load), int(np.linalg.matrix_rank(jacobian))
        )

    def _closure_jacobian(self) -> Floats:
        world = self.plant.world_frame()
        one, two = (
            self.plant.CalcJacobianSpatialVelocity(
                self.context,
                JacobianWrtVariable.kV,
                self.plant.GetFrameByName(name),
                np.zeros(3),
                world,
                world,
            )
            for name in ("wrist2", "nut2")
        )
        return np.asarray(one - two)

    def _closure_bias(self) -> Floats:
        world = self.plant.world_frame()
        one, two = (
            self.plant.CalcBiasSpatialAcceleration(
                self.context,
                JacobianWrtVariable.kV,
                self.plant.GetFrameByName(name),
                np.zeros(3),
                world,
                world,
            ).get_coeffs()
            for name in ("wrist2", "nut2")
        )
        return np.asarray(one - two)
