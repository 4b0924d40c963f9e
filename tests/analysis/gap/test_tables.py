"""The same signals come out of every format, and what cannot be read is one clear error."""

import gzip
import json
import os
import sys

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from gapscope.analysis.errors import InputError
from gapscope.analysis.gap import tables
from gapscope.analysis.gap.tables import csv_table, matlab_table

SAMPLES = 300
T = 0.001 * np.arange(SAMPLES)
LOG = {"t": T, "q_ref": np.sin(6.0 * T), "q": np.sin(6.0 * T - 0.01), "force": np.cos(6.0 * T)}


def write_csv(path):
    np.savetxt(path, np.column_stack(list(LOG.values())), delimiter=",", header=",".join(LOG),
               comments="", fmt="%.17g")  # fmt: skip


def write_gz(path):
    write_csv(path.with_suffix(""))
    path.write_bytes(gzip.compress(path.with_suffix("").read_bytes()))


def write_parquet(path):
    pa = pytest.importorskip("pyarrow")
    pytest.importorskip("pyarrow.parquet").write_table(pa.table({**LOG, "mode": ["x"] * 300}), path)


def write_hdf5(path):
    with pytest.importorskip("h5py").File(path, "w") as file:
        for name, values in LOG.items():
            file[name] = values


def write_mat(path):
    savemat(path, {name: values[:, None] for name, values in LOG.items()})


def write_mat73(path):
    with pytest.importorskip("h5py").File(path, "w", userblock_size=512) as file:
        for name, values in LOG.items():
            file[name] = values[None, :]  # MATLAB's column, stored transposed
            file[name].attrs["MATLAB_class"] = np.bytes_("double")


WRITERS = {
    "log.csv": write_csv, "log.csv.gz": write_gz, "log.parquet": write_parquet,
    "log.h5": write_hdf5, "log.mat": write_mat, "log73.mat": write_mat73,
}  # fmt: skip


@pytest.mark.parametrize("name", WRITERS)
def test_every_format_gives_the_same_columns(name, tmp_path):
    path = tmp_path / name
    WRITERS[name](path)
    (group,) = tables.read(path)
    assert set(group.columns) == set(LOG)
    whole = np.concatenate(list(tables.blocks(path, ["q", "t"])))
    for values, column in ((whole[:, 0], "q"), (whole[:, 1], "t"), (group.columns["q"], "q")):
        np.testing.assert_array_equal(values, LOG[column])


@pytest.mark.parametrize("name", WRITERS)
def test_a_missing_column_is_named_in_every_format(name, tmp_path):
    path = tmp_path / name
    WRITERS[name](path)
    with pytest.raises(InputError, match=r"no column 'current'.*q_ref"):
        list(tables.blocks(path, ["t", "current"]))


@pytest.mark.parametrize("name", WRITERS)
def test_a_file_cut_short_is_one_error(name, tmp_path):
    path = tmp_path / name
    WRITERS[name](path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2 - 3])
    with pytest.raises(InputError, match=name):
        list(tables.blocks(path, list(LOG)))


@pytest.mark.parametrize(
    ("name", "module", "extra"),
    [("a.parquet", "pyarrow", "parquet"), ("a.h5", "h5py", "hdf5"),
     ("a.mcap", "mcap.reader", "mcap"), ("a.bag", "rosbags.highlevel", "ros")],
)  # fmt: skip
def test_a_missing_extra_names_the_command_that_installs_it(
    name, module, extra, tmp_path, monkeypatch
):
    monkeypatch.setitem(sys.modules, module, None)
    (tmp_path / name).write_bytes(b"")
    with pytest.raises(InputError, match=rf"pip install 'gapscope\[{extra}\]'"):
        tables.read(tmp_path / name)


def test_a_format_nobody_reads_lists_those_that_are(tmp_path):
    (tmp_path / "log.xyz").write_bytes(b"1")
    with pytest.raises(InputError, match=r"'\.xyz'.*Parquet.*MATLAB.*ROS bag"):
        tables.read(tmp_path / "log.xyz")


@pytest.mark.parametrize(
    ("text", "names", "units"),
    [
        ("t [s];q [rad]\n0,0;1,5\n0,1;1,6\n0,2;1,7\n", ["t", "q"], {"t": "s", "q": "rad"}),
        ("# made by a logger\nt\tq\n0.0\t1.5\n0.1\t1.6\n0.2\t1.7\n", ["t", "q"], {}),
        ("t,q\ns,rad\n0.0,1.5\n0.1,1.6\n0.2,1.7\n", ["t", "q"], {"t": "s", "q": "rad"}),
        ("0.0 1.5\n0.1 1.6\n0.2 1.7\n", ["column0", "column1"], {}),
        ("\ufefft,q,mode\n0.0,1.5,a\n0.1,1.6,b\n0.2,1.7,c\n0.3,", ["t", "q"], {}),
    ],
)
def test_text_tables_as_people_write_them(text, names, units, tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(text, encoding="utf-8")
    (group,) = tables.read(path)
    assert list(group.columns) == names
    assert dict(group.units) == units
    columns = list(group.columns.values())
    np.testing.assert_allclose(columns[0], [0.0, 0.1, 0.2])
    np.testing.assert_allclose(columns[1], [1.5, 1.6, 1.7])


def test_structures_with_a_time_of_their_own_are_groups(tmp_path):
    slow = T[::10]
    savemat(
        tmp_path / "log.mat",
        {
            "drive": {"time": T, "signals": {"values": LOG["q"][:, None], "label": "q"}},
            "logger": {"t": slow, "temperature": 20.0 + slow},
            "gain": 3.0,
        },
    )
    drive, logger = tables.read(tmp_path / "log.mat")
    assert (drive.name, drive.time, drive.samples) == ("drive", "time", 300)
    assert set(drive.columns) == {"time", "signals.values"}
    assert (logger.name, logger.time, logger.samples) == ("logger", "t", 30)


def test_structures_of_every_kind_come_back_from_the_child_as_scipy_reads_them(tmp_path):
    path = tmp_path / "log.mat"
    wide, odd = np.arange(12.0).reshape(2, 6), np.array([np.nan, np.inf, -0.0, 5e-324])
    savemat(
        path,
        {"a": wide, "whole": np.arange(6, dtype=np.int16), "s": {"t": odd, "x": odd[::-1]}},
        do_compression=True,
    )
    columns = {f"{g.name}.{n}": c for g in tables.read(path) for n, c in g.columns.items()}
    wanted = loadmat(path, simplify_cells=True)
    assert set(columns) == {".a[0]", ".a[1]", ".whole", "s.t", "s.x"}
    for name, values in (
        (".a[0]", wanted["a"][0]), (".a[1]", wanted["a"][1]), (".whole", wanted["whole"]),
        ("s.t", wanted["s"]["t"]), ("s.x", wanted["s"]["x"]),
    ):  # fmt: skip
        assert columns[name].tobytes() == values.astype(np.float64).tobytes(), name


def test_a_mat_file_of_version_4_is_read(tmp_path):
    savemat(tmp_path / "log.mat", LOG, format="4")
    (group,) = tables.read(tmp_path / "log.mat")
    np.testing.assert_array_equal(group.columns["q"], LOG["q"])


def read_by(program, folder, monkeypatch):
    """Read a good .mat file, but with ``program`` as the module that the reading process runs."""
    write_mat(folder / "log.mat")
    (folder / "stand_in.py").write_text(program)
    monkeypatch.setenv("PYTHONPATH", str(folder))
    monkeypatch.setattr(matlab_table, "READER", "stand_in")
    return tables.read(folder / "log.mat")


def test_a_reader_that_hangs_is_ended(tmp_path, monkeypatch):
    monkeypatch.setattr(matlab_table, "PATIENCE", 2.0)
    pid = tmp_path / "pid"
    hangs = f"import os, time; open({str(pid)!r}, 'w').write(str(os.getpid())); time.sleep(600)"
    with pytest.raises(InputError, match=r"log\.mat: not read within 2 s; expected a MATLAB.*copy"):
        read_by(hangs, tmp_path, monkeypatch)
    with pytest.raises(ProcessLookupError):
        os.kill(int(pid.read_text()), 0)


def test_a_reader_that_crashes_is_one_error(tmp_path, monkeypatch):
    with pytest.raises(
        InputError, match=r"log\.mat: it crashed its reader \(SIGABRT\); expected a"
    ):
        read_by("import os; os.abort()", tmp_path, monkeypatch)


@pytest.mark.parametrize("call", [tables.read, lambda path: list(tables.blocks(path, ["t"]))])
@pytest.mark.parametrize(("name", "reader"), [("log.mat", matlab_table), ("log.csv", csv_table)])
def test_a_file_that_may_not_be_read_is_one_error(tmp_path, monkeypatch, call, name, reader):
    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    (tmp_path / name).write_text("t\n0\n")
    monkeypatch.setattr(reader, "open", refuse, raising=False)
    with pytest.raises(InputError, match=rf"{name}: cannot be read \(Permission denied\)"):
        call(tmp_path / name)


def test_a_file_that_only_ends_in_mat_starts_no_reader(tmp_path, monkeypatch):
    monkeypatch.setattr(matlab_table, "READER", "no_such_module")
    (tmp_path / "log.mat").write_text("t,q\n" + "0.0,1.0\n" * 100)
    with pytest.raises(InputError, match=r"its header is not one that MATLAB writes"):
        tables.read(tmp_path / "log.mat")


def test_mcap_topics_are_groups_and_stamps_are_times(tmp_path):
    writer_module = pytest.importorskip("mcap.writer")
    path = tmp_path / "log.mcap"
    with open(path, "wb") as stream:
        writer = writer_module.Writer(stream)
        writer.start()
        channel = writer.register_channel("/axis", "json", 0)
        for t, q in zip(T, LOG["q"]):
            content = {"header": {"stamp": {"sec": 5, "nanosec": round(1e9 * t)}}, "q": [q, 1]}
            time = round(1e9 * (5.0 + 2.0 * t))
            writer.add_message(channel, time, json.dumps(content).encode(), time)
        writer.finish()
    (group,) = tables.read(path)
    assert (group.name, group.time) == ("/axis", "header.stamp")
    np.testing.assert_allclose(group.columns["header.stamp"], 5.0 + T, rtol=1e-12)
    np.testing.assert_array_equal(group.columns["q[0]"], LOG["q"])


@pytest.mark.parametrize("version", [1, 2])
def test_ros_bags_name_the_joints_of_a_joint_state(version, tmp_path):
    pytest.importorskip("rosbags.highlevel")
    path = write_bag(tmp_path, version)
    (group,) = tables.read(path)
    assert group.name == "/joint_states"
    assert group.time == "header.stamp"
    np.testing.assert_allclose(group.columns["header.stamp"], T, atol=1e-9)
    np.testing.assert_array_equal(group.columns["position.left"], LOG["q"])
    np.testing.assert_array_equal(group.columns["effort.right"], LOG["force"])


def write_bag(folder, version):
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if version == 1 else Stores.LATEST)
    kind = "sensor_msgs/msg/JointState"
    types = store.types
    path = folder / ("log.bag" if version == 1 else "bag")
    writer = Writer1(path) if version == 1 else Writer2(path, version=9)
    with writer:
        connection = writer.add_connection("/joint_states", kind, typestore=store)
        for i, t in enumerate(T):
            stamp = types["builtin_interfaces/msg/Time"](sec=0, nanosec=round(1e9 * t))
            counted = {"seq": i} if version == 1 else {}
            message = types[kind](
                header=types["std_msgs/msg/Header"](stamp=stamp, frame_id="", **counted),
                name=["left", "right"],
                position=np.array([LOG["q"][i], 0.0]),
                velocity=np.zeros(0),
                effort=np.array([0.0, LOG["force"][i]]),
            )
            data = (
                store.serialize_ros1(message, kind) if version == 1 else
                store.serialize_cdr(message, kind)
            )  # fmt: skip
            writer.write(connection, round(1e9 * t) + 7, data)
    return path
