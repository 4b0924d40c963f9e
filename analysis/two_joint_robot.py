"""A two-joint arm in Drake's Simulator, logged as your own robot would be: a machine for an example.

It shares nothing with what diagnoses it but the model file: Drake integrates, friction is an arctangent
of the speed, the payload is a body welded to the arm.
"""

import shutil
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import yaml

DT = 0.001  # of the controller [s]
STEPS = 2  # of the simulation in one sample
KP, KD = (90.0, 50.0), (6.0, 3.0)
STEP = 2.0 * np.pi / 2**17  # of the encoders [rad]
MODEL = "two_joint_arm.sdf"


def record(
    folder: Path,
    *,
    friction: Sequence[float] = (0.0, 0.0),
    payload: float = 0.0,
    hum: float = 0.0,
    amplitudes: Sequence[float] = (0.5, 0.8, 0.65),
    duration: float = 4.0,
) -> Path:
    """Write a log set of the arm: dry friction [N m] by joint, a mass at its tip [kg], a hum [N m].

    The last of the ``amplitudes`` [rad] becomes the validation run. The hum is a torque of 3.7 Hz on the
    shoulder, which no effect of the catalogue makes.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with resources.as_file(resources.files("gapscope.models") / MODEL) as path:
        shutil.copy(path, folder / MODEL)
        tables = [_run(path, a, friction, payload, hum, duration) for a in amplitudes]
    runs = []
    for i, table in enumerate(tables):
        use = "validate" if i == len(tables) - 1 else "fit"
        runs.append({"file": f"run{i + 1}.csv", "use": use, "rate_Hz": 0.5})
        header = "t,shoulder_ref,elbow_ref,shoulder,elbow,shoulder_tau,elbow_tau"
        np.savetxt(folder / f"run{i + 1}.csv", table, "%.9g", ",", header=header, comments="")
    logset = {
        "format": 1,
        "name": "two_joint_arm",
        "system": {"model": MODEL, "joints": ["shoulder", "elbow"],
                   "payload": {"body": "forearm", "point": [0.25, 0.0, 0.0]}},
        "controller": {"kind": "joint_pd", "kp": list(KP), "kd": list(KD),
                       "gravity_compensation": True},
        "sample_time_s": DT,
        "columns": {"t": "s", "JOINT_ref": "rad", "JOINT": "rad", "JOINT_tau": "N m"},
        "runs": runs,
    }  # fmt: skip
    (folder / "logset.yaml").write_text(yaml.safe_dump(logset, sort_keys=False), encoding="utf-8")
    return folder


def _run(
    path: Path, amplitude: float, friction: Sequence[float], payload: float, hum: float,
    duration: float,
) -> np.ndarray:  # fmt: skip
    """Time, reference, readings and commands of one run, (samples, 7)."""
    from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig

    plant, compensation = _plant(path, payload), _plant(path, 0.0)
    simulator = Simulator(plant)
    config = SimulatorConfig(
        integration_scheme="runge_kutta3", max_step_size=DT / STEPS, use_error_control=False
    )
    ApplySimulatorConfig(config, simulator)
    context = simulator.get_mutable_context()
    model = compensation.CreateDefaultContext()
    reference, rate = _reference(0.0, amplitude)
    plant.SetPositions(context, reference)
    plant.SetVelocities(context, rate)
    port = plant.get_actuation_input_port()
    before = STEP * np.round(reference / STEP)
    rows = []
    for k in range(round(duration / DT)):
        t = k * DT
        reference, rate = _reference(t, amplitude)
        reading = STEP * np.round(plant.GetPositions(context) / STEP)
        compensation.SetPositions(model, reading)
        load = -compensation.CalcGravityGeneralizedForces(model)
        command = KP * (reference - reading) + KD * (rate - (reading - before) / DT) + load
        before = reading
        rows.append(np.concatenate([[t], reference, reading, command]))
        for step in range(STEPS):
            now = t + step * DT / STEPS
            rub = np.array(friction) * 2.0 / np.pi * np.arctan(plant.GetVelocities(context) / 2e-3)
            port.FixValue(context, command - rub + [hum * np.sin(2.0 * np.pi * 3.7 * now), 0.0])
            simulator.AdvanceTo(now + DT / STEPS)
    return np.array(rows)


def _reference(t: float, amplitude: float) -> tuple[np.ndarray, np.ndarray]:
    """Angles and rates of a motion that repeats every two seconds."""
    w = np.pi * np.array([1.0, 2.0, 3.0])
    share = np.array([[0.7, 0.2, -0.15], [-0.5, 0.3, 0.2]])
    phase = np.array([[0.0, 1.0, 2.0], [0.5, 0.0, 1.5]])
    angles = amplitude * np.sum(share * np.sin(w * t + phase), axis=1)
    rates = amplitude * np.sum(share * w * np.cos(w * t + phase), axis=1)
    return angles + np.array([-0.6, 0.9]), rates


def _plant(path: Path, payload: float) -> Any:
    from pydrake.math import RigidTransform
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import SpatialInertia

    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(path)
    if payload > 0.0:
        ball = plant.AddRigidBody(
            "payload", plant.GetModelInstanceByName("two_joint_arm"),
            SpatialInertia.SolidSphereWithMass(payload, 0.005),
        )  # fmt: skip
        place: Any = np.array([0.25, 0.0, 0.0])
        plant.WeldFrames(plant.GetFrameByName("forearm"), ball.body_frame(), RigidTransform(place))
    plant.Finalize()
    return plant
