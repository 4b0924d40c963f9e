"""A C-drive with dry friction that its log set does not mention, measured in four short runs."""

import numpy as np
import pytest
import yaml

from gapscope.analysis.gap import diagnosis, effects
from gapscope.models import c_drive, drive, drive_kernels
from gapscope.models.c_drive import CDriveParameters
from gapscope.models.c_drive_controllers import PD, loop_controller
from gapscope.models.encoder import resolution
from gapscope.models.motion import c_drive_motion

DT = 0.001
LEVEL = 0.3  # dry friction of the left bearing [N m]
BIAS = 0.1  # load on the right shaft [N m]
MACHINES = {"friction": (LEVEL, 0.0), "two": (LEVEL, BIAS), "nothing": (0.0, 0.0)}
TRIED = ("smoothed sign", "linear", "constant")  # forms of dry and viscous friction and of a load
HOSTILE = "<img src=x onerror=\"document.title='broken'\">&.csv"
RUNS = (
    ("translation.csv", "translation", 2.0, "fit"),
    ("rotation.csv", "rotation", 2.0, "fit"),
    ("helical.csv", "helical", 2.0, "fit"),
    (HOSTILE, "helical", 2.5, "validate"),
)


def simulated(motion, rate, level, bias):
    """Time, reference, position and command of at least two cycles."""
    parameters = CDriveParameters()
    plant = c_drive.drive(parameters).copy()
    plant.element[0, [drive.FORWARD, drive.BACKWARD]] = level
    plant.shaft[1, drive.BIAS] = bias
    controller = loop_controller(PD(), parameters, DT)
    t = DT * np.arange(1000)
    reference, _, acceleration = c_drive_motion(motion, rate).sample(t)
    position, command, delivered = (np.zeros_like(reference) for _ in range(3))
    memory = drive_kernels.initial_memory(controller, reference[0])
    position[0] = reference[0]
    drive_kernels.simulate(
        reference, np.ascontiguousarray(acceleration), plant, controller, DT, 4, resolution(13),
        memory, position, command, delivered,
    )  # fmt: skip
    return np.column_stack([t, reference, position, command])


def write_logset(folder, level, bias, name):
    nominal = CDriveParameters()
    columns = {"t": "s", "psi_L_ref": "rad", "psi_R_ref": "rad", "psi_L": "rad", "psi_R": "rad",
               "tau_L": "Nm", "tau_R": "Nm"}  # fmt: skip
    gains = {"kp_Nm_per_rad": 45.0, "kd_Nms_per_rad": 0.1, "derivative_filter_rad_per_s": 600.0}
    document = {
        "format": 1,
        "name": name,
        "system": {
            "kind": "c_drive",
            "nominal": {"beta_N_m_s": nominal.beta, "gamma_N_m_s": nominal.gamma},
        },
        "controllers": {"pd": {"kind": "pd", **gains}},
        "sample_time_s": DT,
        "columns": columns,
        "runs": [
            {"file": file, "controller": "pd", "motion": motion, "rate_Hz": rate, "use": use}
            for file, motion, rate, use in RUNS
        ],
    }
    folder.mkdir()
    (folder / "logset.yaml").write_text(yaml.safe_dump(document), encoding="utf-8")
    for file, motion, rate, _ in RUNS:
        table = simulated(motion, rate, level, bias)
        np.savetxt(folder / file, table, "%.9f", ",", header=",".join(columns), comments="")
    return folder


@pytest.fixture(scope="session")
def diagnosed(tmp_path_factory):
    """Diagnoses of a machine with friction, with friction and a load, and as its nominal model."""
    root = tmp_path_factory.mktemp("logsets")
    with pytest.MonkeyPatch.context() as patch:
        every = effects.forms_for
        patch.setattr(
            effects,
            "forms_for",
            lambda *args: [f for f in every(*args) if f.name in TRIED],
        )
        return {
            name: diagnosis.diagnose(write_logset(root / name, *size, f"{name} </script> & <b>"))
            for name, size in MACHINES.items()
        }
