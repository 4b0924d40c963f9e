"""Memory of a diagnosis: of an open set, and of ten hours at 1 kHz, of which the report says what was read."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from gapscope.models import c_drive, drive, drive_kernels
from gapscope.models.c_drive_controllers import PD, loop_controller
from gapscope.models.encoder import resolution
from gapscope.models.motion import c_drive_motion

from .conftest import CONTROLLERS, DT, description

HOURS = 10
HOUR = 3_600_000  # rows
PART = 200_000  # rows of each hour that are simulated; the hour repeats them, whole cycles
LEVEL = 0.3  # dry friction of the left bearing, which the nominal model lacks [N m]
CAP = 4 << 30  # bytes
CAP_OF_SHORT_LOGS = 1 << 30  # bytes
DIAGNOSE = """
import json, resource, sys
from pathlib import Path
from gapscope.analysis.commands.diagnose import diagnose
diagnose(logset=sys.argv[1], out=Path(sys.argv[2]), quiet=True)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)
assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss == 0  # no other process to count
"""


def peak_of_diagnosis(logset, out):
    """Peak resident memory of a process that diagnoses [byte]."""
    done = subprocess.run(
        [sys.executable, "-c", DIAGNOSE, str(logset), str(out)],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return int(done.stdout)


def hour(number):
    """Rows (PART, 7) of the log from a machine with dry friction, moving otherwise in every hour."""
    parameters = c_drive.CDriveParameters()
    plant = c_drive.drive(parameters).copy()
    plant.element[0, [drive.FORWARD, drive.BACKWARD]] = LEVEL
    program = ("translation", "rotation", "helical")[number % 3]
    warm_up = 2_000
    t = DT * np.arange(PART + warm_up)
    reference, _, acceleration = c_drive_motion(program, 1.0 + 0.5 * (number % 4)).sample(t)
    controller = loop_controller(PD(), parameters, DT)
    position, command, delivered = (np.zeros_like(reference) for _ in range(3))
    memory = drive_kernels.initial_memory(controller, position[0])
    drive_kernels.simulate(
        np.ascontiguousarray(reference), np.ascontiguousarray(acceleration), plant, controller, DT, 2,
        resolution(13), memory, position, command, delivered,
    )  # fmt: skip
    return np.column_stack([np.zeros(len(t)), reference, position, command])[warm_up:]


def write_ten_hours(folder):
    """The log as Parquet, never whole in memory."""
    arrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    names = list(description()["columns"])
    schema = arrow.schema([(name, arrow.float64()) for name in names])
    with parquet.ParquetWriter(folder / "run.parquet", schema) as writer:
        for number in range(HOURS):
            rows = hour(number)
            for part in range(HOUR // PART):
                rows[:, 0] = DT * (number * HOUR + part * PART + np.arange(PART))
                writer.write_table(arrow.table(dict(zip(names, rows.T))))
    document = description() | {"name": "ten hours"}
    document["controllers"] = {"pd": document["controllers"]["pd"]}
    document["runs"] = [{"file": "run.parquet", "use": "fit", "controller": "pd"}]
    (folder / "logset.yaml").write_text(yaml.safe_dump(document))


@pytest.mark.slow
def test_ten_hours_at_a_kilohertz_are_diagnosed_within_four_gigabytes(tmp_path):
    assert CONTROLLERS["pd"]["kp_Nm_per_rad"] == PD().kp
    write_ten_hours(tmp_path)
    assert peak_of_diagnosis(tmp_path, tmp_path / "out") < CAP
    found = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert found["verdict"] == "explained"
    assert [effect["id"] for effect in found["effects"]] == ["friction.coulomb"]
    page = (tmp_path / "out" / "report.html").read_text()
    for text in (found["warnings"][0], page):
        assert f"{HOURS * HOUR} rows over 36000 s are too many to fit: 10 stretches" in text
        assert "what happens between the stretches is not judged" in text


@pytest.mark.slow
@pytest.mark.parametrize("name", ["backlash", "coulomb_and_bias"])
def test_an_open_set_is_diagnosed_within_a_gigabyte(name, tmp_path):
    data = os.environ.get("GAPSCOPE_DATA")
    folder = Path(data).parent / "gap" / "open" / name if data else None
    if folder is None or not folder.is_dir():
        pytest.skip("GAPSCOPE_DATA is not set, or ../gap/open is not beside it")
    assert peak_of_diagnosis(folder, tmp_path) < CAP_OF_SHORT_LOGS
