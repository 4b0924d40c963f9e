"""Log sets for the instrument's tests, simulated on the spot or found through GAPSCOPE_DATA."""

import os
from pathlib import Path

import numpy as np
import pytest
import yaml

from gapscope.models import c_drive, drive_kernels, motion
from gapscope.models.c_drive_controllers import PD, TaskSpacePD, loop_controller
from gapscope.models.encoder import resolution

DT = 1e-3
RUNS = [
    ("pd", "translation", 2.0, "fit"),
    ("pd", "rotation", 2.0, "fit"),
    ("pd", "helical", 2.0, "fit"),
    ("ts", "helical", 2.0, "validate"),
]
CONTROLLERS = {
    "pd": {"kind": "pd", "kp_Nm_per_rad": 45.0, "kd_Nms_per_rad": 0.1},
    "ts": {
        "kind": "task_space_pd",
        "kp_trans_Nm_per_rad": 45.0,
        "kp_rot_Nm_per_rad": 112.5,
        "kd_trans_Nms_per_rad": 0.1,
        "kd_rot_Nms_per_rad": 0.25,
    },
}


def description():
    """``logset.yaml`` of the simulated C-drive, as a dictionary."""
    return {
        "format": 1,
        "name": "simulated",
        "system": {
            "kind": "c_drive",
            "nominal": {"beta_N_m_s": 4.148e-3, "gamma_N_m_s": 2.792e-3},
        },
        "controllers": {
            name: {**settings, "derivative_filter_rad_per_s": 600.0}
            for name, settings in CONTROLLERS.items()
        },
        "sample_time_s": DT,
        "columns": {
            "t": "s", "psi_L_ref": "rad", "psi_R_ref": "rad",
            "psi_L": "rad, 13-bit encoder", "psi_R": "rad, 13-bit encoder",
            "tau_L": "Nm, commanded", "tau_R": "Nm, commanded",
        },
        "runs": [
            {"file": f"run{i}.csv", "controller": c, "motion": m, "rate_Hz": rate, "use": use}
            for i, (c, m, rate, use) in enumerate(RUNS)
        ],
    }  # fmt: skip


def write_logset(folder, change=lambda plant: None, cycles=3, seed=0):
    """Simulate the benchmark with a changed drive and write it as a log set into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    document = description()
    (folder / "logset.yaml").write_text(yaml.safe_dump(document, sort_keys=False))
    rng = np.random.default_rng(seed)
    parameters = c_drive.CDriveParameters()
    plant = c_drive.drive(parameters).copy()
    change(plant)
    settings = {"pd": PD(), "ts": TaskSpacePD()}
    for i, (name, program, rate, _) in enumerate(RUNS):
        t = DT * np.arange(round(cycles / (rate * DT)))
        reference, _, acceleration = motion.c_drive_motion(program, rate).sample(t)
        controller = loop_controller(settings[name], parameters, DT)
        position, command, delivered = (np.zeros_like(reference) for _ in range(3))
        memory = drive_kernels.initial_memory(controller, position[0])
        drive_kernels.simulate(
            reference, acceleration, plant, controller, DT, 2, resolution(13), memory,
            position, command, delivered,
        )  # fmt: skip
        command = command + rng.normal(0.0, 0.002, command.shape)
        table = np.column_stack([t, reference, position, command])
        np.savetxt(
            folder / f"run{i}.csv", table, delimiter=",", comments="", fmt="%.6f",
            header="t,psi_L_ref,psi_R_ref,psi_L,psi_R,tau_L,tau_R",
        )  # fmt: skip
    return folder


@pytest.fixture(scope="session")
def nominal_logset(tmp_path_factory):
    """A log set of a machine without a gap."""
    return write_logset(tmp_path_factory.mktemp("nominal") / "set")


@pytest.fixture(scope="session")
def shared_data():
    """Folder of the measured logs."""
    if "GAPSCOPE_DATA" not in os.environ:
        pytest.skip("GAPSCOPE_DATA is not set: the measured logs are not on this machine")
    return Path(os.environ["GAPSCOPE_DATA"]).resolve()


@pytest.fixture(scope="session")
def open_sets(shared_data):
    """Folder of the labelled sets of the independent simulator, beside the measured logs."""
    folder = shared_data.parent / "gap" / "open"
    if not folder.is_dir():
        pytest.skip(f"{folder} is not there: the labelled log sets are not on this machine")
    return folder
