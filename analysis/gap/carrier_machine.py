"""The PepperMill-Carrier as the instrument sees it: posture-dependent inertia behind four motors.

Predicted by ``models.pmc.prediction``. All signals are motor angles and torques; the encoders count from joints
``home``.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...models import drive_kernels, encoder
from ...models.drive import VISCOUS, Drive
from ...models.pmc import constants, displacement, dynamics, prediction
from ...models.pmc.control import Controller
from ...models.pmc.parameters import PMCParameters
from ...models.pmc.prediction import ELEMENTS, MOTORS, Carrier
from . import floor as floors
from .machine import Array, Machine, Parameter, RunData, own_parameter

if TYPE_CHECKING:
    from .effects import Form

# Of the prediction's correction [rad/s]: slow, for the limbs make the motors' common motion heavy.
BANDWIDTH = 20.0
# Limbs and PM turn and slide with the difference and the sum of a C-drive's motors.
TASK = ("d1", "theta1", "d2", "theta2")


@dataclass
class CarrierPlant:
    """The robot that effects act on."""

    robot: Carrier
    inertia: Array  # (4, 4) felt at the motors in the middle of the motion [kg m^2]
    substeps: int = 1
    time: float = 0.0  # how long the machine has been running [s]
    sensor_scale: Array | None = None  # (4,) reading per motor angle

    @property
    def drive(self) -> Drive:
        """Actuators and friction elements."""
        return self.robot.drive

    @drive.setter
    def drive(self, changed: Drive) -> None:
        self.robot = self.robot._replace(drive=changed)

    def finished(self) -> "CarrierPlant":
        """The plant as it is predicted."""
        return self


@dataclass(frozen=True, kw_only=True)
class CarrierRun(RunData):
    """A run with what the controller wants in joints and pose, arrays (samples, 4)."""

    joints: Array
    joint_acceleration: Array
    pose: Array
    pose_acceleration: Array


@dataclass(frozen=True, kw_only=True)
class CarrierMachine(Machine):
    """Nominal model of a PepperMill-Carrier."""

    parameters: PMCParameters
    home: Array  # (4,) joints at motor angles zero [m, rad]
    middle: Array  # (4,) joints in the middle of the logged motion
    elements: tuple[str, ...] = ELEMENTS
    viscous_own: tuple[str, ...] = (*(f"beta_{m}" for m in MOTORS), "gamma", "gamma")
    ripples: Mapping[str, float]  # spatial frequencies [1/rad] by the name of a period

    def build(self, values: Mapping[str, float]) -> CarrierPlant:
        """A fresh plant at the own parameters' values."""
        p = self.parameters
        robot = prediction.carrier(p, self.home)
        c, at = robot.constants, values
        limbs, rotors = at["limb_mass"] / p.limb_mass, at["rotor_inertia"] - p.rotor_inertia
        rope = at["counterweight"] - p.counterweight.mass
        changed = c._replace(
            axial_mass=c.axial_mass
            + at["limb_mass"] - p.limb_mass + 2.0 * rotors * c.per_metre**2,
            crank_inertia=c.crank_inertia
            + (limbs - 1.0) * (p.proximal_inertia + p.proximal_mass * p.proximal_centre**2)
            + 2.0 * rotors,
            crank_moment=limbs * c.crank_moment,
            rod_mass=limbs * c.rod_mass,
            rod_inertia=limbs * c.rod_inertia,
            wrist_mass=limbs * c.wrist_mass,
            mill_mass=at["pepper_mill_mass"],
            rope_mass=c.rope_mass + rope,
            rope_weight=c.rope_weight + rope * c.gravity,
            elbow_damping=at["elbow_damping"],
            wrist_damping=at["wrist_damping"],
        )  # fmt: skip
        robot.drive.element[:, VISCOUS] = [
            *(at[f"beta_{m}"] for m in MOTORS),
            0.5 * at["gamma"],
            0.5 * at["gamma"],
        ]
        inertia = self.motor_inertia(self.middle)
        return CarrierPlant(robot=robot._replace(constants=changed), inertia=inertia)

    def predict(self, run: RunData, plant: CarrierPlant) -> Array:
        """Prediction error (samples, 4) of the encoders over the run's window [rad]."""
        scale = 1.0 if plant.sensor_scale is None else plant.sensor_scale
        residual = np.empty_like(run.position)
        prediction.predict(
            run.position / scale,
            run.command,
            plant.robot,
            run.dt,
            plant.substeps,
            BANDWIDTH,
            residual,
        )
        return np.asarray((residual * scale)[run.window])

    def forms(self, runs: Sequence[RunData]) -> "list[Form]":
        """Effects of motors and encoders, and those of limbs, PM and counterweight."""
        from .effects import carrier_forms, scales_of  # they name this class

        return carrier_forms.forms(self, scales_of(runs))

    @property
    def task_rows(self) -> tuple[tuple[str, ...], Array]:
        """Slide and turn of each C-drive, with rows of length one."""
        rows = np.kron(np.eye(2), np.array([[1.0, -1.0], [1.0, 1.0]]) / np.sqrt(2.0))
        return TASK, rows

    @property
    def bandwidth(self) -> float:
        """Of the prediction's correction [rad/s]."""
        return BANDWIDTH

    def motor_inertia(self, joints: Array) -> Array:
        """Inertia matrix (4, 4) felt at the motors at joints (4,) [kg m^2]."""
        c, still = constants.of(self.parameters), (0.0,) * 4
        matrix = np.zeros((4, 4))
        matrix[np.triu_indices(4)] = dynamics.equations(tuple(joints), still, c)[0]
        matrix = matrix + np.triu(matrix, 1).T
        to_joints = constants.joint_map(self.parameters.drive.lead)
        return np.asarray(to_joints.T @ matrix @ to_joints)

    def unexplained(self, residual: Array, run: RunData) -> Array:
        """Motor torques (k, 4) that would cause a prediction error, with the inertia of the middle posture."""
        _, beta = drive_kernels.correction_gains(BANDWIDTH, run.dt)
        return np.asarray(residual @ self.motor_inertia(self.middle).T * (beta / run.dt))

    def floor(self, runs: Sequence[RunData], residuals: Sequence[Array]) -> tuple[list[Array], str]:
        """Cycle-to-cycle repeatability, never below what the encoders' resolution does."""
        counted = [replace(run, lsb=run.lsb or self._count()) for run in runs]
        return floors.noise_floor(counted, residuals, BANDWIDTH)

    def out_of_step(self, runs: Sequence[RunData], residuals: Sequence[Array]) -> float | None:
        """What does not repeat, over the encoders' noise."""
        return floors.out_of_step(runs, residuals, BANDWIDTH)

    def simulate(self, run: RunData, plant: CarrierPlant) -> tuple[Array, Array] | None:
        """Motor angles and commands (samples, 4) of the whole loop on the run's reference.

        The loop closes over an exact encoder: a plant with a sensor scale gives NaN.
        """
        if not isinstance(run, CarrierRun) or not isinstance(run.controller, Controller):
            return None
        position, command = run.position.copy(), run.command.copy()
        if plant.sensor_scale is not None:
            return np.full_like(position, np.nan), np.full_like(position, np.nan)
        prediction.simulate(
            run.joints,
            run.joint_acceleration,
            run.pose,
            run.pose_acceleration,
            run.controller,
            plant.robot,
            run.dt,
            plant.substeps,
            run.lsb,
            position,
            command,
        )
        return position, command

    def unit(self, quantity: str) -> str:
        """Unit of a quantity: position, effort, rate, viscous or stiffness."""
        return {
            "position": "rad",
            "effort": "N m",
            "rate": "rad/s",
            "viscous": "N m s/rad",
            "stiffness": "N m/rad",
        }[quantity]

    def _count(self) -> float:
        bits = self.parameters.encoder_bits
        return encoder.resolution(bits) if bits else 1e-9


def own_parameters(p: PMCParameters, relative: float) -> tuple[Parameter, ...]:
    """What a nominal PepperMill-Carrier may be wrong about within its tolerance."""
    own = {
        "pepper_mill_mass": ("kg", p.pepper_mill_mass + p.payload),
        "limb_mass": ("kg", p.limb_mass),
        "counterweight": ("kg", p.counterweight.mass),
        "rotor_inertia": ("kg m^2", p.rotor_inertia),
        **{f"beta_{m}": ("N m s/rad", p.drive.beta) for m in MOTORS},
        "gamma": ("N m s/rad", p.drive.gamma),
        "elbow_damping": ("N m s/rad", p.elbow_damping),
        "wrist_damping": ("N m s/rad", p.wrist_damping),
    }
    return tuple(own_parameter(name, unit, v, relative) for name, (unit, v) in own.items())


def joints_of(angles: Array, home: Array, parameters: PMCParameters) -> Array:
    """Joints (samples, 4) of motor angles counted from ``home``."""
    return np.asarray(home + angles @ constants.joint_map(parameters.drive.lead).T)


def poses_of(joints: Array, parameters: PMCParameters) -> Any:
    """Poses (samples, 4) on the working branch; NaN out of reach."""
    dim = parameters.geometry.dimensions
    with np.errstate(invalid="ignore"):
        return np.column_stack(displacement.pose(tuple(joints.T), -1.0, -1.0, dim))
