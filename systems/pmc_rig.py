r"""A second, independent PepperMill-Carrier: multibody tree with multipliers, drive trains and an elastic rope.

It shares no law with the closed-form robot, so that its logs are a fair trial of models fitted to them:

1. all ten joints of the tree move, the cut is closed by six multipliers:
   :math:`M\dot v + C v + D v = \tau + J^T\lambda,\ J\dot v = -\dot J v - 2\kappa J v`;
2. motors: :math:`\tau = T^T (\mathrm{clip}(g x) - F v / \sqrt{v^2 + w^2} - \ldots)`, x the command behind its lag;
3. the counterweight hangs on a spring: :math:`m \ddot s = F - m_c g - F_p`, F the force of the rope.
"""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.systems.framework import BasicVector, LeafSystem

from ..models import encoder
from ..models.pmc import constants
from ..models.pmc.parameters import PMCParameters
from .pmc_plant import DRIVEN, add_pmc, tree_positions

Floats = NDArray[np.float64]
FOUR = (0.0, 0.0, 0.0, 0.0)
ROPE_STIFFNESS = 2e5  # [N/m]
ROPE_DAMPING = 500.0  # [N s/m]
CLOSING = 100.0  # kappa, rate at which a speed that opens the loop dies away [1/s]


@dataclass(frozen=True, kw_only=True)
class RigEffects:
    """What the motors and encoders of a rig have that no nominal model has; by motor (L1, R1, L2, R2).

    Raises ValueError for a value that is no number, or a negative time or stiffness.
    """

    dry: tuple[float, ...] = FOUR  # dry friction of the motors [N m]
    dry_nuts: tuple[float, ...] = (0.0, 0.0)  # of the nuts of both C-drives [N m]
    dry_speed: float = 0.3  # w of the smoothed sign [rad/s]
    viscous: tuple[float, ...] = FOUR  # beyond that of the plant [N m s/rad]
    load_share: tuple[float, ...] = FOUR  # dry friction per magnitude of motor torque [-]
    bias: tuple[float, ...] = FOUR  # load against positive motor torque [N m]
    gain: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)  # torque delivered per torque commanded [-]
    delay: int = 0  # of the command [samples]
    lag: float = 0.0  # time constant of the torque loops [s]
    limit: float = np.inf  # of a motor's torque [N m]
    stiffness: float = 0.0  # between drive and link in theta1 and theta2, 0 is rigid [N m/rad]
    stiffness_damping: float = 0.0  # [N m s/rad]
    offset: tuple[float, ...] = FOUR  # by how much the joints exceed what the encoders say [m, rad]
    scale: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)  # encoder reading per motor angle [-]

    def __post_init__(self) -> None:
        for item in fields(self):
            value = np.atleast_1d(getattr(self, item.name))
            signed = item.name not in ("delay", "lag", "stiffness", "stiffness_damping")
            if np.isnan(value).any() or (not signed and value.min() < 0.0):
                raise ValueError(f"rig: {item.name} is {getattr(self, item.name)}; expected a size")


class RigRobot(LeafSystem):
    """The robot of the module's docstring with encoders that count from joints ``home`` (4,).

    | port | size | unit |
    |---|---|---|
    | in  `command`  | 4 | N m, motors (L1, R1, L2, R2) |
    | out `measured` | 4 | rad, motors from home, whole counts |

    Continuous state: positions and rates of the tree, rope paid out [m], lagged commands [N m], drive sides of
    theta1 and theta2 [rad]; at rest at joints ``start`` (4,), rope and counterweight in balance.
    """

    def __init__(
        self, parameters: PMCParameters, effects: RigEffects, home: ArrayLike, start: ArrayLike
    ) -> None:
        LeafSystem.__init__(self)
        self.parameters, self.effects = parameters, effects
        self.plant = MultibodyPlant(0.0)
        add_pmc(self.plant, parameters, closed=False)
        if effects.stiffness > 0.0:
            _free_of_rotors(self.plant)
        self.plant.Finalize()
        self.inside = self.plant.CreateDefaultContext()
        self.map = constants.motor_map(parameters.drive.lead)
        self.home = np.asarray(home, dtype=float) + effects.offset
        joints = [self.plant.GetJointByName(name) for name in DRIVEN]
        self.driven = [joint.velocity_start() for joint in joints]
        self.damping = np.zeros(self.plant.num_velocities())
        for index in self.plant.GetJointIndices():
            joint = self.plant.get_joint(index)
            first, count = joint.velocity_start(), joint.num_velocities()
            self.damping[first : first + count] = joint.default_damping_vector()[:count]
        self.cut = [self.plant.GetFrameByName(name) for name in ("wrist2", "nut2")]
        self.mill = self.plant.GetFrameByName("pepper_mill")
        weight = parameters.counterweight
        self.rope_end = np.array([0.0, 0.0, weight.rope_height])
        self.pulley = np.array([weight.x, weight.y, weight.z])
        q = tree_positions(start, self.plant, parameters.geometry)
        self.n = len(q)
        self.plant.SetPositions(self.inside, q)
        paid = self._rope_length()[0] - weight.mass * parameters.gravity / ROPE_STIFFNESS
        turned = np.asarray(start, dtype=float)[2:]
        positions, rates = np.concatenate([q, [paid], turned]), np.zeros(self.n + 3)
        state = np.concatenate([positions, rates, np.zeros(4)])
        self.DeclareContinuousState(BasicVector(state), len(rates), len(rates), 4)
        self.DeclareVectorInputPort("command", 4)
        self.DeclareVectorOutputPort(
            "measured", 4, self._read, prerequisites_of_calc={self.xc_ticket()}
        )

    def DoCalcTimeDerivatives(self, context: Any, derivatives: Any) -> None:
        """Drake's hook: rates, and accelerations by laws (1) to (3)."""
        n, e = self.n, self.effects
        x = context.get_continuous_state_vector().CopyToVector()
        position, rate, lagged = x[: n + 3], x[n + 3 : 2 * n + 6], x[2 * n + 6 :]
        command = self.GetInputPort("command").Eval(context)
        self.plant.SetPositionsAndVelocities(self.inside, np.concatenate([position[:n], rate[:n]]))
        side = self.driven if e.stiffness == 0.0 else [*self.driven[:2], n + 1, n + 2]
        force = self.map.T @ self._motor_torques(command if e.lag == 0.0 else lagged, rate[side])
        turning = np.zeros(2)
        if e.stiffness > 0.0:
            twist, slip = (s[n + 1 :] - s[self.driven[2:]] for s in (position, rate))
            spring = e.stiffness * twist + e.stiffness_damping * slip
            loss = 2.0 * self.parameters.drive.beta * rate[n + 1 :]
            turning = (force[2:] - spring - loss) / (2.0 * self.parameters.rotor_inertia)
            force = np.append(force[:2], spring)
        pull, on_joints = self._rope(position[n], rate[n])
        on_joints[self.driven] += force
        tree = self._tree_acceleration(rate[:n], on_joints)
        lagging = np.zeros(4) if e.lag == 0.0 else (command - lagged) / e.lag
        derivatives.get_mutable_vector().SetFromVector(
            np.concatenate([rate, tree, [self._weight(pull, rate[n])], turning, lagging])
        )

    def closure_error(self, context: Any) -> float:
        """Distance between the two sides of the cut [m]."""
        x = context.get_continuous_state_vector().CopyToVector()
        self.plant.SetPositions(self.inside, x[: self.n])
        one, two = (frame.CalcPoseInWorld(self.inside).translation() for frame in self.cut)
        return float(np.linalg.norm(one - two))

    def _motor_torques(self, asked: Floats, joint_rates: Floats) -> Floats:
        """Torques (4,) behind actuators and friction, law (2)."""
        e = self.effects
        torque = np.clip(np.multiply(e.gain, asked), -e.limit, e.limit)
        speed = self.map @ joint_rates
        sign = speed / np.hypot(speed, e.dry_speed)
        slip = np.array([speed[0] - speed[1], speed[2] - speed[3]])
        nuts = np.multiply(e.dry_nuts, slip / np.hypot(slip, e.dry_speed))
        level = np.add(e.dry, np.multiply(e.load_share, np.abs(torque)))
        loss = level * sign + np.multiply(e.viscous, speed)
        return np.asarray(torque - loss - np.repeat(nuts, 2) * [1, -1, 1, -1] - e.bias)

    def _tree_acceleration(self, v: Floats, force: Floats) -> Floats:
        """Law (1) at the positions and rates of the inner context."""
        plant, world = self.plant, self.plant.world_frame()
        (j1, b1), (j2, b2) = (
            (
                plant.CalcJacobianSpatialVelocity(
                    self.inside, JacobianWrtVariable.kV, frame, np.zeros(3), world, world
                ),
                plant.CalcBiasSpatialAcceleration(
                    self.inside, JacobianWrtVariable.kV, frame, np.zeros(3), world, world
                ).get_coeffs(),
            )
            for frame in self.cut
        )
        jacobian, n = j1 - j2, self.n
        matrix = np.zeros((n + 6, n + 6))
        matrix[:n, :n] = plant.CalcMassMatrix(self.inside)
        matrix[:n, n:], matrix[n:, :n] = -jacobian.T, jacobian
        load = plant.CalcBiasTerm(self.inside) + self.damping * v
        load -= plant.CalcGravityGeneralizedForces(self.inside)
        closing = b2 - b1 - 2.0 * CLOSING * (jacobian @ v)
        return np.asarray(np.linalg.solve(matrix, np.concatenate([force - load, closing]))[:n])

    def _rope_length(self) -> tuple[float, Floats]:
        """Length from pulley to PM [m] and direction away from the pulley."""
        away = self.mill.CalcPoseInWorld(self.inside) @ self.rope_end - self.pulley
        length = float(np.linalg.norm(away))
        return length, away / length

    def _rope(self, paid: float, paid_rate: float) -> tuple[float, Floats]:
        """Force of the rope [N] and its generalised forces on the tree (n,), law (3)."""
        if self.parameters.counterweight.mass == 0.0:
            return 0.0, np.zeros(self.n)
        length, away = self._rope_length()
        world = self.plant.world_frame()
        jacobian = self.plant.CalcJacobianTranslationalVelocity(
            self.inside, JacobianWrtVariable.kV, self.mill, self.rope_end, world, world
        )
        v = self.plant.GetVelocities(self.inside)
        slide = float(away @ jacobian @ v) - paid_rate
        force = max(ROPE_STIFFNESS * (length - paid) + ROPE_DAMPING * slide, 0.0)
        return force, -force * (jacobian.T @ away)

    def _weight(self, pull: float, rate: float) -> float:
        weight = self.parameters.counterweight
        if weight.mass == 0.0:
            return 0.0
        drag = weight.pulley_friction * rate / np.hypot(rate, weight.friction_speed)
        mass = weight.mass + weight.pulley_inertia / weight.pulley_radius**2
        return float((pull - weight.mass * self.parameters.gravity - drag) / mass)

    def _read(self, context: Any, output: Any) -> None:
        x = context.get_continuous_state_vector().CopyToVector()
        joints = x[self.driven]
        if self.effects.stiffness > 0.0:
            joints[2:] = x[self.n + 1 : self.n + 3]
        angle = np.multiply(self.effects.scale, self.map @ (joints - self.home))
        count = encoder.resolution(self.parameters.encoder_bits)
        output.SetFromVector(count * np.rint(angle / count))


def _free_of_rotors(plant: MultibodyPlant) -> None:
    """Take the rotors and their friction off the drive angles: they turn on their own."""
    for name in DRIVEN[2:]:
        joint: Any = plant.GetJointByName(name)  # revolute
        joint.set_default_damping(0.0)
        actuator = plant.get_mutable_joint_actuator(plant.GetJointActuatorByName(name).index())
        actuator.set_default_rotor_inertia(0.0)
