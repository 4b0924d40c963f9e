"""A map over many cases in worker processes that can be killed and taken up again."""

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from .files import write_whole


def resumable_map(
    function: Callable[..., Any],
    cases: Iterable[dict[str, Any]],
    folder: Path,
    *,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[Any]:
    """Results of ``function(**case)`` in the order of ``cases``.

    Cases and results are JSON values. Each finished result is one file in ``folder``, named by a hash of the
    function and the case: a second call computes only what is missing. ``function`` must be importable, for the
    workers start afresh. Raises what ``function`` raises; finished cases are kept.
    """
    if workers < 1:
        raise ValueError(f"workers is {workers}; expected at least 1")
    folder.mkdir(parents=True, exist_ok=True)
    wanted = [(case, folder / f"{_digest(function, case)}.json") for case in cases]
    missing = [(case, path) for case, path in wanted if not path.exists()]
    done = len(wanted) - len(missing)
    progress(done, len(wanted))
    with _results(function, missing, workers) as results:
        for path, value in results:
            write_whole(path, json.dumps(value))
            done += 1
            progress(done, len(wanted))
    return [json.loads(path.read_text()) for _, path in wanted]


@contextmanager
def _results(
    function: Callable[..., Any], cases: list[tuple[dict[str, Any], Path]], workers: int
) -> Iterator[Iterator[tuple[Path, Any]]]:
    if workers == 1:
        yield ((path, function(**case)) for case, path in cases)
        return
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        futures = {pool.submit(function, **case): path for case, path in cases}
        try:
            yield ((futures[future], future.result()) for future in as_completed(futures))
        finally:
            pool.shutdown(cancel_futures=True)


def _digest(function: Callable[..., Any], case: dict[str, Any]) -> str:
    identity = [function.__module__, function.__qualname__, case]
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:24]
