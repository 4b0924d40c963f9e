"""What is fuzzed: valid seeds written by each format's own library, and the call that reads them."""

import contextlib
import json
import os
import random
import shutil
from pathlib import Path

import numpy as np
import yaml

SAMPLES = 150
T = 0.001 * np.arange(SAMPLES)
LOG = {"t": T, "q_ref": np.sin(9.0 * T), "q": np.sin(9.0 * T - 0.1), "force": np.cos(9.0 * T)}
DESCRIPTION = {
    "format": 1,
    "name": "seed",
    "system": {"kind": "slider", "nominal": {"mass_kg": 95.0, "viscous_N_s_per_m": 203.0}},
    "controller": {
        "kind": "cascade_p_p", "kp_per_s": 160.0, "kv_V_per_m_per_s": 243.0, "saturation_V": 10.0,
        "force_per_volt_N": 35.0, "encoder_lsb_m": 5e-8,
    },
    "sample_time_s": 0.001,
    "columns": {"t": "s", "q_ref": "m", "q": "m", "force": "N"},
    "runs": [{"file": "run.csv", "use": "fit"}, {"file": "other.csv", "use": "validate"}],
}  # fmt: skip
FILES = ("log.csv", "log.csv.gz", "log.parquet", "log.h5", "log.mat", "log73.mat", "log.mcap",
         "log.bag", "bag/bag.db3", "bag/metadata.yaml")  # fmt: skip
TARGETS = (
    *FILES,
    "logset.yaml",
    "run.csv",
    "import",
    "config",
    "pmc-config",
    "motion",
    "steps",
    "arguments",
)
RISKY = ["nan", "-1", "0", "1e999", "", "a" * 300, "\x00", "é", "../x", "-", "--", "{}", "[1]", "=",
         "t=", "q=q:zz", "q=log:q", "=q", "inf", "1", "csv", "slider", "c_drive", "axis", "emps"]  # fmt: skip


def write_seeds(folder: Path) -> None:
    """Every seed file, by the library of its format."""
    import gzip

    import h5py
    import pyarrow as pa
    import pyarrow.parquet
    from scipy.io import savemat

    folder.mkdir(parents=True, exist_ok=True)
    table = np.column_stack(list(LOG.values()))
    np.savetxt(
        folder / "log.csv", table, delimiter=",", header=",".join(LOG), comments="", fmt="%.9g"
    )
    (folder / "log.csv.gz").write_bytes(gzip.compress((folder / "log.csv").read_bytes()))
    pyarrow.parquet.write_table(pa.table(LOG), folder / "log.parquet")
    for name, userblock in (("log.h5", 0), ("log73.mat", 512)):
        with h5py.File(folder / name, "w", userblock_size=userblock) as file:
            for column, values in LOG.items():
                file.create_dataset(f"axis/{column}", data=values, compression="gzip")
    savemat(folder / "log.mat", {"axis": LOG, "gain": 3.0, "note": "text"}, do_compression=False)
    _write_recordings(folder)
    (folder / "logset.yaml").write_text(yaml.safe_dump(DESCRIPTION, sort_keys=False))
    (folder / "run.csv").write_bytes((folder / "log.csv").read_bytes())
    table[:, 2] *= 1.01  # another recording of the motion
    np.savetxt(
        folder / "other.csv", table, delimiter=",", header=",".join(LOG), comments="", fmt="%.9g"
    )
    _write_configs(folder)


def _write_recordings(folder: Path) -> None:
    from mcap.writer import Writer
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    (folder / "log.bag").unlink(missing_ok=True)  # the writers refuse to overwrite
    shutil.rmtree(folder / "bag", ignore_errors=True)
    with open(folder / "log.mcap", "wb") as stream:
        writer = Writer(stream)
        writer.start()
        channel = writer.register_channel("/axis", "json", 0)
        for row in zip(*LOG.values()):
            at = round(1e9 * row[0])
            writer.add_message(
                channel, at, json.dumps(dict(zip(LOG, map(float, row)))).encode(), at
            )
        writer.finish()
    kind = "geometry_msgs/msg/Point"
    for store, writer, serialize in (
        (get_typestore(Stores.ROS1_NOETIC), Writer1(folder / "log.bag"), "serialize_ros1"),
        (get_typestore(Stores.LATEST), Writer2(folder / "bag", version=9), "serialize_cdr"),
    ):
        with writer:
            connection = writer.add_connection("/axis", kind, typestore=store)
            for t, x, y in zip(T, LOG["q"], LOG["force"]):
                data = getattr(store, serialize)(store.types[kind](x=x, y=y, z=0.0), kind)
                writer.write(connection, round(1e9 * t), data)


def _write_configs(folder: Path) -> None:
    from importlib.resources import files

    loop = (files("gapscope.diagrams") / "c_drive_loop.yaml").read_text()
    (folder / "config").write_text(loop)
    (folder / "pmc-config").write_text("controller: pd\ncycle: industry\nspeed: 1.0\n")
    (folder / "motion").write_text(
        "name: m\nperiod: 1.0\n"
        "cosine: {left: [0.1, 0.02], right: [0.1, 0.0]}\nsine: {left: [0.0, 0.1], right: [0.1, 0.0]}\n"
    )
    from gapscope.analysis.mm3a import experiments
    from gapscope.analysis.mm3a.runs import write_runs

    write_runs(
        folder / "steps", experiments.full_experiment("empirical", days=1, repeats=1, seed=0)
    )


def read_tables(path: Path) -> list:
    """Every group of signals of a file."""
    from gapscope.analysis.gap import tables

    return tables.read(path)


def input_error() -> type[Exception]:
    """The one error of unusable input; imported late, for fuzzers that watch imports."""
    from gapscope.analysis.errors import InputError

    return InputError


def attempt(target: str, seeds: Path, seed: int, scratch: Path) -> str:
    """Feed one mutated input to its reader; ``ok`` or ``refused``. Anything else is raised."""
    from gapscope.analysis.errors import InputError

    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    try:
        with contextlib.chdir(scratch):
            _call(target, seeds, seed, scratch)
    except InputError:
        return "refused"
    return "ok"


def _call(target: str, seeds: Path, seed: int, scratch: Path) -> None:
    if target == "arguments":
        command_line(arguments(seeds, seed))
        return
    from .mutation import mutated

    if target == "import":
        name = random.Random(seed).choice(
            ["log.csv", "log.mat", "log.h5", "log.mcap", "log.parquet"]
        )
        path = _put(seeds, name, mutated((seeds / name).read_bytes(), seed), scratch)
        command_line(
            ["import", str(path), "--kind", "slider", "--yes", "--resample", "--out", "out"]
        )
        return
    read(target, mutated((seeds / target).read_bytes(), seed), seeds, scratch)


def read(target: str, data: bytes, seeds: Path, scratch: Path) -> None:
    """Hand ``data`` to the reader of a target, as a file in the folder ``scratch``."""
    path = _put(seeds, target, data, scratch)
    if target in ("logset.yaml", "run.csv"):
        from gapscope.analysis.gap.logset import load_logset
        from gapscope.analysis.gap.machines import read_machine

        other = "run.csv" if target == "logset.yaml" else "logset.yaml"
        for name in (other, "other.csv"):
            shutil.copy(seeds / name, scratch / name)
        read_machine(load_logset(scratch))
    elif target in FILES:
        read_tables(path.parent if target.startswith("bag/") else path)
    else:
        _config(target, path)


def _config(target: str, path: Path) -> None:
    from gapscope.analysis.errors import InputError

    if target == "steps":
        from gapscope.analysis.mm3a.runs import read_runs

        read_runs(path)
        return
    # These loaders say ValueError, OSError or RuntimeError; the commands turn them into one line.
    try:
        if target == "config":
            from gapscope.diagrams.c_drive_config import load_config

            load_config(path).program()
        elif target == "motion":
            from gapscope.models.fourier_motion import load_motion

            load_motion(path)
        else:
            from gapscope.diagrams.pmc_loop import PMCLoopConfig

            PMCLoopConfig.load(path)
    except (ValueError, OSError, RuntimeError) as error:
        raise InputError(path, str(error), "a config") from error


def _put(seeds: Path, name: str, data: bytes, scratch: Path) -> Path:
    if name.startswith("bag/"):
        shutil.copytree(seeds / "bag", scratch / "bag")
    path = scratch / name
    path.write_bytes(data)
    return path


def arguments(seeds: Path, seed: int) -> list[str]:
    """A command line of real options and values that may be anything."""
    rng = random.Random(seed)
    paths = [str(seeds / name) for name in ("log.csv", "logset.yaml", "steps", "missing", "")]
    shapes = [
        ["import", "P", "--out", "V", "--kind", "V", "--yes"],
        ["import", "P", "--out", "o", "--column", "V", "--rate", "V", "--yes"],
        [
            "import",
            "P",
            "--out",
            "o",
            "--model",
            "P",
            "--format",
            "V",
            "--sample-time",
            "V",
            "--yes",
        ],
        ["data", "get", "V", "--out", "V"],
        ["data", "V"],
        ["diagnose", "V", "--out", "V", "--seed", "V"],
        ["calibrate", "mm3a", "--data", "P", "V"],
        ["simulate", "c-drive", "--config", "V", "--motion", "V", "--cycles", "V", "--out", "V"],
        ["simulate", "V", "--out", "V"],
        ["compare", "V"],
        ["blind", "--cases", "V", "--seed", "V"],
        ["design", "V", "--error", "V", "--travel", "V"],
        ["workspace", "pmc", "--out", "o", "--grid", "V", "--workers", "V", "--nonsense"],
        ["V", "V"],
    ]
    fill = {"P": paths, "V": RISKY}
    shape = [rng.choice(fill[word]) if word in fill else word for word in rng.choice(shapes)]
    if rng.random() < 0.2:
        shape.insert(rng.randrange(len(shape)), rng.choice(RISKY))
    return shape


def command_line(words: list[str]) -> None:
    """Run the command line in this process as ``main`` does; usage errors and exits are answers."""
    from typer.testing import CliRunner

    from gapscope.analysis.cli import app

    os.environ.pop("GAPSCOPE_DATA", None)
    result = CliRunner().invoke(app, words)
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
