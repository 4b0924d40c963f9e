"""Cases shared among processes of this machine (joblib) or a Dask cluster; results as they finish.

The result of a case depends on the case alone, so all three ways give the same bits, provided that the machines
run the same versions (checked with every case) on processors that round alike. A worker that dies gives its
cases back; a case that takes down ``ATTEMPTS`` workers in a row ends the run, and finished cases are kept.
"""

import platform
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator
from importlib.metadata import version
from typing import Any, NamedTuple

from .errors import InputError

ATTEMPTS = 4
PATIENCE = "30 s"  # for a scheduler to answer and a worker to join
MUST_AGREE = ("gapscope", "drake", "numpy", "scipy", "numba")

Call = tuple[Any, ...]


class Finished(NamedTuple):
    """What a worker of the cluster gives back, told apart from an error by its type."""

    value: Any


def each(
    function: Callable[..., Any],
    calls: Iterable[Call],
    *,
    workers: int = 1,
    cluster: str | None = None,
) -> Generator[tuple[int, Any]]:
    """(number of the call, ``function(*call)``) in the order they finish; ``calls`` is read as needed.

    ``workers`` processes of this machine (1: this process), or the workers of the Dask scheduler at ``cluster``,
    such as ``tcp://host:8786``. Raises what ``function`` raises, ValueError for fewer than one worker, and
    InputError if the cluster cannot be used or a case keeps ending its worker.
    """
    if workers < 1:
        raise ValueError(f"workers is {workers}; expected at least 1")
    if cluster is not None:
        if workers > 1:
            raise InputError("--cluster", "given beside --workers", "one of the two")
        return _on_cluster(function, calls, cluster)
    if workers == 1:
        return (_numbered(i, function, call) for i, call in enumerate(calls))
    return _in_processes(function, calls, workers)


def _in_processes(
    function: Callable[..., Any], calls: Iterable[Call], workers: int
) -> Generator[tuple[int, Any]]:
    from joblib import Parallel, delayed
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    waiting = enumerate(calls)
    begun: dict[int, Call] = {}

    def tasks(again: dict[int, Call]) -> Iterator[Any]:
        for i, call in again.items():
            yield delayed(_numbered)(i, function, call)
        for i, call in waiting:
            begun[i] = call
            yield delayed(_numbered)(i, function, call)

    attempts = 0
    while attempts < ATTEMPTS:
        parallel = Parallel(n_jobs=workers, return_as="generator_unordered", batch_size=1)
        results = parallel(tasks(dict(begun)))
        try:
            for i, value in results:
                attempts = 0
                del begun[i]
                yield i, value
            return
        except TerminatedWorkerError:
            attempts += 1
        finally:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # joblib's, of cases it abandons
                results.close()
    raise _ends_its_workers("--workers")


def _numbered(i: int, function: Callable[..., Any], call: Call) -> tuple[int, Any]:
    return i, _on_one_thread(function, call)


def _on_one_thread(function: Callable[..., Any], call: Call) -> Any:
    """The result with one thread of linear algebra: the last bits of a sum depend on their number."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        return function(*call)


def _on_cluster(
    function: Callable[..., Any], calls: Iterable[Call], address: str
) -> Generator[tuple[int, Any]]:
    distributed = _distributed()
    versions = _versions()
    waiting = enumerate(calls)
    with _client(distributed, address) as client:
        finished = distributed.as_completed(loop=client.loop, with_results=True, raise_errors=False)
        number: dict[Any, int] = {}

        def submit() -> None:
            room = 2 * sum(client.nthreads().values()) - len(number)
            for _, (i, call) in zip(range(max(room, 1 - len(number))), waiting):
                future = client.submit(_same_versions, versions, function, call, pure=False)
                number[future] = i
                finished.add(future)

        submit()
        try:
            for future, result in finished:
                # not by the status: it becomes "lost" when a worker dies after its result has come
                if not isinstance(result, Finished):
                    _refuse(distributed, future, address)
                i = number.pop(future)
                submit()
                yield i, result.value
        finally:
            client.cancel(list(number), force=True)


def _distributed() -> Any:
    try:
        import distributed
    except ImportError:
        raise InputError(
            "--cluster",
            "dask.distributed is not installed",
            "the extra `cluster`",
            "pip install 'gapscope[cluster]'",
        ) from None
    return distributed


def _client(distributed: Any, address: str) -> Any:
    try:
        client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(
            f"--cluster {address}",
            f"no Dask scheduler answers ({error})",
            "the address a scheduler prints, such as tcp://host:8786",
            "Start one with `dask scheduler` and workers with `dask worker ADDRESS`.",
        ) from None
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError:
        client.close()
        raise InputError(
            f"--cluster {address}",
            f"has no worker after {PATIENCE}",
            "at least one",
            f"Start some with `dask worker {address}`.",
        ) from None
    return client


def _refuse(distributed: Any, future: Any, address: str) -> None:
    """Raise why a case of the cluster failed."""
    error = future.exception() if future.status == "error" else None
    if isinstance(error, distributed.scheduler.KilledWorker):
        raise _ends_its_workers(f"--cluster {address}")
    if error is None:
        raise InputError(
            f"--cluster {address}",
            "the scheduler went away",
            "one that stays until the end",
            "Finished cases are kept; repeat the command to go on.",
        )
    raise error


def _ends_its_workers(where: str) -> InputError:
    return InputError(
        where,
        f"a case ended its worker {ATTEMPTS} times",
        "workers that survive a case",
        "Most often memory ran out: use fewer. Finished cases are kept; repeat to go on.",
    )


def _versions() -> dict[str, str]:
    return {"python": platform.python_version()} | {name: version(name) for name in MUST_AGREE}


def _same_versions(expected: dict[str, str], function: Callable[..., Any], call: Call) -> Finished:
    """Runs on a worker of the cluster."""
    found = _versions()
    for name, wanted in expected.items():
        if found[name] != wanted:
            raise InputError(
                f"worker {platform.node()}",
                f"has {name} {found[name]}",
                f"{wanted} as where the run was started",
                "Install the same versions everywhere: results would differ in their bits.",
            )
    return Finished(_on_one_thread(function, call))
