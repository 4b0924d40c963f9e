"""Three ways to share cases give the same results, and survive the loss of a worker."""

import json
import os
import pickle
import signal
import time

import numpy as np
import pytest
import threadpoolctl

from gapscope.analysis import blind_check
from gapscope.analysis.errors import InputError
from gapscope.analysis.pmc.workspace import optimise_row
from gapscope.analysis.resumable import resumable_map
from gapscope.analysis.workers import ATTEMPTS, each
from gapscope.models.pmc.geometry import Geometry

from .blind_runs import outcome


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory):
    """Address of a local Dask scheduler with two worker processes."""
    distributed = pytest.importorskip(
        "distributed", reason="dask.distributed is not installed: pip install 'gapscope[cluster]'"
    )
    folder = tmp_path_factory.mktemp("dask")
    with distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        dashboard_address="127.0.0.1:0",
        local_directory=str(folder),
    ) as cluster:
        yield cluster.scheduler_address


@pytest.fixture(params=["processes", "cluster"])
def share(request):
    """Keywords of each way to share."""
    if request.param == "processes":
        return {"workers": 2}
    return {"cluster": request.getfixturevalue("scheduler")}


def test_linear_algebra_runs_on_one_thread_everywhere(share):
    """The last bits of a sum depend on the number of threads."""

    def threads():
        np.linalg.eigh(np.eye(2))  # loads a library where there was none
        return [library["num_threads"] for library in threadpoolctl.threadpool_info()]

    for keywords in ({}, share):
        ((_, found),) = each(threads, [()], **keywords)
        assert set(found) == {1}


def deadly(folder, times):
    """A function that kills its worker process the first ``times`` times case 2 comes by."""
    kill, here = signal.SIGKILL, os.getpid()

    def function(x):
        if x == 2:
            for attempt in range(times):
                marker = folder / f"killed{attempt}"
                if not marker.exists():
                    assert os.getpid() != here
                    marker.touch()
                    os.kill(os.getpid(), kill)
        return np.random.default_rng(x).normal(size=3).tolist()

    return function


def test_a_killed_worker_costs_no_case_and_no_bit(share, tmp_path):
    cases = [{"x": x} for x in range(8)]
    (tmp_path / "killed0").touch()
    expected = resumable_map(deadly(tmp_path, 1), cases, tmp_path / "alone")
    (tmp_path / "killed0").unlink()
    seen = []
    found = resumable_map(
        deadly(tmp_path, 1),
        cases,
        tmp_path / "shared",
        progress=lambda done, total: seen.append(done),
        **share,
    )
    assert (tmp_path / "killed0").exists()  # a worker was lost
    assert found == expected
    assert seen == list(range(9))
    for path in (tmp_path / "alone").iterdir():
        assert (tmp_path / "shared" / path.name).read_bytes() == path.read_bytes()


def test_a_worker_killed_after_its_results_came_costs_none_of_them(scheduler, tmp_path):
    distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")

    def slow_the_second_time(x):
        if (tmp_path / str(x)).exists():
            time.sleep(1)
        (tmp_path / str(x)).touch()
        return x * x

    results = each(slow_the_second_time, [(x,) for x in range(3)], cluster=scheduler)
    found = [next(results)]
    while len(list(tmp_path.iterdir())) < 3:
        time.sleep(0.01)
    time.sleep(0.2)  # for the results to come
    with distributed.Client(scheduler, set_as_default=False) as client:
        for process in client.run(os.getpid).values():
            os.kill(process, signal.SIGKILL)
    time.sleep(0.3)  # for the scheduler to tell of the loss
    assert sorted(found + list(results)) == [(x, x * x) for x in range(3)]


def test_a_workspace_row_has_the_same_bits_everywhere(share, tmp_path):
    geometry = Geometry()
    ys = np.linspace(geometry.carriage_min, geometry.carriage_max, 3).tolist()
    cases = [{"x": ys[i], "ys": ys, "extreme": "low", "geometry": vars(geometry)} for i in range(2)]
    expected = resumable_map(optimise_row, cases, tmp_path / "alone")
    assert resumable_map(optimise_row, cases, tmp_path / "shared", **share) == expected


def test_a_case_that_ends_every_worker_ends_the_run_in_one_message(share, tmp_path):
    with pytest.raises(InputError, match=f"ended its worker {ATTEMPTS} times"):
        list(each(deadly(tmp_path, 20), [(2,)], **share))
    assert len(list(tmp_path.glob("killed*"))) == ATTEMPTS


def test_an_interrupted_map_goes_on_and_repeats_nothing(share, tmp_path):
    counts = tmp_path / "counts"
    counts.mkdir()

    def counted(x):
        (counts / f"{x}-{len(list(counts.glob(f'{x}-*')))}").touch()
        return x * x

    def interrupt(done, total):
        if done == 3:
            raise KeyboardInterrupt

    cases = [{"x": x} for x in range(40)]
    with pytest.raises(KeyboardInterrupt):
        resumable_map(counted, cases, tmp_path / "results", progress=interrupt, **share)
    kept = [json.loads(p.read_text()) for p in (tmp_path / "results").glob("*.json")]
    assert len(kept) == 3
    assert resumable_map(counted, cases, tmp_path / "results", **share) == [
        x * x for x in range(40)
    ]
    root = {x * x: x for x in range(40)}
    assert all(len(list(counts.glob(f"{root[value]}-*"))) == 1 for value in kept)


def test_a_blind_run_on_the_cluster_is_the_run_of_one_process(scheduler, tmp_path):
    def said(logset, out):
        (out / "diagnosis.json").write_text("{}")
        return {"verdict": "no_gap", "files": sorted(p.name for p in logset.iterdir())}

    one, many = (
        blind_check.run(seed=7, cases=1, out=tmp_path / name, diagnose=said, **share)
        for name, share in (("one", {}), ("many", {"cluster": scheduler}))
    )
    assert [answer for answer, _ in one] == [answer for answer, _ in many]
    assert [r["diagnosis"] for _, r in one] == [r["diagnosis"] for _, r in many]
    assert (tmp_path / "many" / "diagnoses" / "case_0000" / "diagnosis.json").exists()


@pytest.mark.slow
def test_real_blind_cases_survive_a_killed_worker_of_the_cluster_bit_for_bit(tmp_path):
    distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")
    blind_check.run(seed=12, cases=3, out=tmp_path / "alone")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0",
        local_directory=str(tmp_path / "dask"),
    ) as cluster:  # fmt: skip
        killed = []

        def kill_one(stage, done, total):
            if stage == "diagnose" and done == 1:
                with distributed.Client(cluster) as client:
                    busy = next(worker for worker, tasks in client.processing().items() if tasks)
                    killed.append(client.run(os.getpid)[busy])
                os.kill(killed[0], signal.SIGKILL)

        blind_check.run(
            seed=12, cases=3, out=tmp_path / "many", cluster=cluster.scheduler_address,
            progress=kill_one,
        )  # fmt: skip
        with distributed.Client(cluster) as client:
            assert killed[0] not in client.run(os.getpid).values()
    assert outcome(tmp_path / "many") == outcome(tmp_path / "alone")


def test_errors_of_a_case_come_through(share):
    def refuse(path):
        raise InputError(path, "empty", "a table", "Fill it.")

    with pytest.raises(InputError, match=r"x.csv: empty; expected a table. Fill it."):
        list(each(refuse, [("x.csv",)], **share))


def test_a_worker_with_another_version_is_refused(scheduler, monkeypatch):
    monkeypatch.setattr("gapscope.analysis.workers._versions", lambda: {"numpy": "0.1"})
    with pytest.raises(InputError, match=r"has numpy .*; expected 0.1"):
        list(each(abs, [(-1,)], cluster=scheduler))


def test_no_scheduler_is_one_message(monkeypatch):
    pytest.importorskip("distributed", reason="dask.distributed is not installed")
    monkeypatch.setattr("gapscope.analysis.workers.PATIENCE", "0.2 s")
    with pytest.raises(InputError, match="no Dask scheduler answers"):
        list(each(abs, [(-1,)], cluster="tcp://127.0.0.1:9"))
    with pytest.raises(InputError, match="no Dask scheduler answers"):
        list(each(abs, [(-1,)], cluster="nonsense://x"))


def test_workers_beside_a_cluster_are_refused():
    with pytest.raises(InputError, match="one of the two"):
        each(abs, [(-1,)], workers=2, cluster="tcp://127.0.0.1:9")


def test_an_input_error_survives_the_way_between_processes():
    error = InputError("run1.csv", "empty", "a table", "Fill it.")
    assert str(pickle.loads(pickle.dumps(error))) == str(error)
