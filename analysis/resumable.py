"""A map over many cases in worker processes that can be killed and taken up again."""

import hashlib
import json
from collections.abc import Callable, Iterable
from contextlib import closing
from pathlib import Path
from typing import Any

from .files import drop_drafts, write_whole
from .workers import each


def resumable_map(
    function: Callable[..., Any],
    cases: Iterable[dict[str, Any]],
    folder: Path,
    *,
    workers: int = 1,
    cluster: str | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[Any]:
    """Results of ``function(**case)`` in the order of ``cases``.

    Cases and results are JSON values. Each finished result is one file in ``folder``, named by a hash of the
    function and the case: a second call computes only what is missing. ``workers`` and ``cluster`` as in
    ``workers.each``; ``function`` must be importable there. Raises what ``function`` raises; finished cases are kept.
    """
    folder.mkdir(parents=True, exist_ok=True)
    drop_drafts(folder)  # of a run that was killed while it wrote
    wanted = [(case, folder / f"{_digest(function, case)}.json") for case in cases]
    missing = [(case, path) for case, path in wanted if not path.exists()]
    done = len(wanted) - len(missing)
    progress(done, len(wanted))
    calls = [(function, case) for case, _ in missing]
    with closing(each(_call, calls, workers=workers, cluster=cluster)) as results:
        for i, value in results:
            write_whole(missing[i][1], json.dumps(value))
            done += 1
            progress(done, len(wanted))
    return [json.loads(path.read_text()) for _, path in wanted]


def _call(function: Callable[..., Any], case: dict[str, Any]) -> Any:
    return function(**case)


def _digest(function: Callable[..., Any], case: dict[str, Any]) -> str:
    identity = [function.__module__, function.__qualname__, case]
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:24]
