"""Logs of a second PepperMill-Carrier (``systems.pmc_rig``) under the sampled controllers."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

from ..models.pmc import control, simulation
from ..models.pmc.controllers import controller
from ..models.pmc.parameters import PMCParameters
from ..systems.pmc_rig import RigEffects, RigRobot
from .pmc_loop import PMCLoopConfig

Floats = NDArray[np.float64]
SETTLING = 0.2  # during which the robot holds the first reference before the log begins [s]


@dataclass(frozen=True, kw_only=True)
class Rig:
    """A robot that may differ from what its computer believes, and its flaws."""

    robot: PMCParameters = field(default_factory=PMCParameters)
    effects: RigEffects = field(default_factory=RigEffects)
    step: float = 1e-3  # of the third-order Runge-Kutta integration [s]


@dataclass(frozen=True)
class RigLog:
    """What the computer knows of one run, arrays (samples, 4); motors (L1, R1, L2, R2)."""

    reference: simulation.Reference
    measured: Floats  # motor angles from home [rad]
    command: Floats  # motor torques [N m]
    closure: float  # distance of the cut bodies at the end [m]


def measure(rig: Rig, config: PMCLoopConfig, cycles: float, home: Floats | None = None) -> RigLog:
    """Run some cycles of a rig under the loop of ``config``, whose parameters its computer believes.

    The encoders read zero at joints ``home`` (4,), by default where the reference starts.
    """
    believed, dt = config.machine(), config.sample_time
    reference = simulation.sample_cycle(
        config.motion(believed), believed, cycles=cycles, sample_time=dt
    )
    home = reference.joints[0] if home is None else np.asarray(home, dtype=float)
    loop = controller(config.settings(), believed, home, dt)
    robot = RigRobot(rig.robot, rig.effects, home, reference.joints[0] + rig.effects.offset)
    simulator: Any = Simulator(robot)
    context = simulator.get_mutable_context()
    ResetIntegratorFromFlags(simulator, "runge_kutta3", rig.step).set_fixed_step_mode(True)
    into = robot.GetInputPort("command")
    into.FixValue(context, np.zeros(4))
    simulator.Initialize()
    before = round(SETTLING / dt)
    n, memory = len(reference.time), np.zeros((5, 4))
    measured, command = np.empty((before + n, 4)), np.empty((before + n, 4))
    for k in range(before + n):
        measured[k] = robot.GetOutputPort("measured").Eval(context)
        if k == 0:
            control.wake_up(measured[0], loop, memory)
        control.step(_target(reference, max(k - before, 0)), measured[k], loop, memory, command[k])
        into.FixValue(context, command[max(k - rig.effects.delay, 0)])
        simulator.AdvanceTo((k + 1) * dt)
    return RigLog(reference, measured[before:], command[before:], robot.closure_error(context))


def _target(reference: simulation.Reference, k: int) -> control.Target:
    return control.Target(
        reference.joints[k],
        reference.joint_accelerations[k],
        reference.poses[k],
        reference.pose_accelerations[k],
    )
