"""The blind check: cases from an independent machine, sealed answers, diagnoses, then the score.

1. Write the log sets of all cases, each answer in its own file with a random salt.
2. Seal: ``sealed.json`` holds the SHA-256 of every salted answer; its own digest is printed first.
3. Diagnose each log set; every result is one file, written whole, so a killed run resumes.
4. Open the answers, recompute the hashes, score (``blind_score``) and report (``blind_report``).

Seeds below 1000 are for tuning an instrument, seeds from 1000 for reporting on it.
"""

import hashlib
import json
import secrets
import shutil
import tempfile
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

from .blind_machine import REPORT_SEEDS_FROM, case_name, write_case
from .errors import InputError
from .files import DRAFT, drop_drafts, output_folder, write_whole
from .workers import each

Diagnose = Callable[[Path, Path], dict[str, Any]]  # log set, output folder -> diagnosis
Files = dict[str, bytes]  # by name
Progress = Callable[[str, int, int], None]  # stage, done, total


def label(seed: int) -> str:
    """What results of this seed may be used for."""
    return "report" if seed >= REPORT_SEEDS_FROM else "tuning"


def instrument(logset: Path, out: Path) -> dict[str, Any]:
    """What ``gapscope diagnose`` writes for this log set."""
    from .commands.diagnose import diagnose

    diagnose(logset=str(logset), out=out, quiet=True)
    result = out / "diagnosis.json"
    if not result.exists():
        raise FileNotFoundError(f"{out}: gapscope diagnose wrote no diagnosis.json")
    diagnosis: dict[str, Any] = json.loads(result.read_text())
    return diagnosis


def run(
    *,
    seed: int,
    cases: int,
    out: Path,
    machine: str = "drive",
    workers: int = 1,
    cluster: str | None = None,
    diagnose: Diagnose = instrument,
    progress: Progress = lambda stage, done, total: None,
    sealed: Callable[[str], None] = lambda digest: None,
) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    """All stages up to the opened answers: (answer, result) of every case, in order.

    ``sealed`` is called with the digest of ``sealed.json`` before the first diagnosis. A result is
    ``{"diagnosis": ..., "error": None, "seconds": ...}``; an instrument that raises has failed that
    case, which is scored as such and tried again when the run is repeated. ``workers`` and ``cluster`` as in
    ``workers.each``; workers share no disk with this process, which alone writes into ``out``.
    Raises InputError if ``out`` holds another run or its seal is broken.
    """
    for folder in (out, out / "cases", out / "answers", out / "results"):
        output_folder(folder)
    _refuse_another_run(out, machine, seed, cases)
    _drop_drafts(out)
    names = [case_name(i) for i in range(cases)]
    share = partial(each, workers=workers, cluster=cluster)
    missing = [i for i in range(cases) if not (out / "answers" / f"{names[i]}.json").exists()]
    written = share(_written, ((machine, seed, i) for i in missing))
    for i, (answer, files) in _told(written, "write", cases, len(missing), progress):
        _keep_case(out, names[missing[i]], answer, files)
    sealed(seal(out, seed, names, machine))
    todo = [name for name in names if not _finished(out / "results" / f"{name}.json")]
    calls = ((diagnose, name, _files(out / "cases" / name)) for name in todo)
    results = share(_diagnosed, calls)
    for i, (result, files) in _told(results, "diagnose", cases, len(todo), progress):
        _keep_result(out, todo[i], result, files)
    broken = verify(out)
    if broken:
        raise InputError(
            out, f"answers do not match the seal: {', '.join(broken)}", "untouched answers"
        )
    return [(_opened(out, name)["answer"], _result(out, name)) for name in names]


def seal(out: Path, seed: int, names: Iterable[str], machine: str = "drive") -> str:
    """Write ``sealed.json`` if it is not there; return its SHA-256."""
    path = out / "sealed.json"
    if not path.exists():
        hashes = {name: _hash(**_opened(out, name)) for name in names}
        content = {
            "machine": machine,
            "seed": seed,
            "use": label(seed),
            "hash": "sha256(salt + JSON of the answer, sorted keys, no spaces)",
            "answers": hashes,
        }
        write_whole(path, json.dumps(content, indent=1) + "\n")
    return hashlib.sha256(path.read_bytes()).hexdigest()


def verify(out: Path) -> list[str]:
    """Names of the cases whose answer or log set differs from what was sealed; empty if none."""
    hashes = json.loads((out / "sealed.json").read_text())["answers"]
    return [
        name
        for name, expected in hashes.items()
        if _hash(**_opened(out, name)) != expected
        or _opened(out, name)["answer"]["logs_sha256"] != _digest_logs(out / "cases" / name)
    ]


def write_drive(seed: int, index: int, directory: Path) -> dict[str, Any]:
    """Write a case of the drives: C-drive or slider."""
    return write_case(seed, index, directory)


def write_mm3a(seed: int, index: int, directory: Path) -> dict[str, Any]:
    """Write a case of the micromanipulator, whose arm is a Drake plant."""
    from .mm3a import blind

    return blind.write_case(seed, index, directory)


MACHINES = {"drive": write_drive, "mm3a": write_mm3a}


def _written(machine: str, seed: int, index: int) -> tuple[dict[str, Any], Files]:
    """Answer and log set of a case; in a worker."""
    with tempfile.TemporaryDirectory() as folder:
        directory = Path(folder) / case_name(index)
        return MACHINES[machine](seed, index, directory), _files(directory)


def _keep_case(out: Path, name: str, answer: dict[str, Any], files: Files) -> None:
    folder, draft = out / "cases" / name, out / "cases" / f"{DRAFT}{name}"
    _put(files, draft)
    shutil.rmtree(folder, ignore_errors=True)
    draft.rename(folder)
    content = {
        "salt": secrets.token_hex(16),
        "answer": answer | {"logs_sha256": _digest_logs(folder)},
    }
    write_whole(out / "answers" / f"{name}.json", json.dumps(content, indent=1) + "\n")


def _diagnosed(diagnose: Diagnose, name: str, logset: Files) -> tuple[dict[str, Any], Files]:
    """Result of a case and the files the instrument wrote; in a worker."""
    with tempfile.TemporaryDirectory() as folder:
        case, written = Path(folder) / name, Path(folder) / "diagnosis"
        _put(logset, case)
        written.mkdir()
        began = time.perf_counter()
        diagnosis, error = None, None
        try:
            diagnosis = diagnose(case, written)
        except Exception as raised:  # a crash is a failed case of the check, not the end of it
            error = f"{type(raised).__name__}: {raised}".replace(folder, "")
        seconds = time.perf_counter() - began
        return {"diagnosis": diagnosis, "error": error, "seconds": seconds}, _files(written)


def _keep_result(out: Path, name: str, result: dict[str, Any], files: Files) -> None:
    folder = output_folder(out / "diagnoses" / name)
    for file, content in files.items():
        write_whole(folder / file, content)
    write_whole(out / "results" / f"{name}.json", json.dumps(result, indent=1) + "\n")


def _files(folder: Path) -> Files:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def _put(files: Files, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        (folder / name).write_bytes(content)


def _told(
    results: Generator[tuple[int, Any]], stage: str, total: int, missing: int, progress: Progress
) -> Iterator[tuple[int, Any]]:
    """The results, each announced after it was taken care of."""
    progress(stage, total - missing, total)
    with closing(results):
        for done, result in enumerate(results, total - missing + 1):
            yield result
            progress(stage, done, total)


def _drop_drafts(out: Path) -> None:
    """Remove what a run that was killed had half written."""
    kept = ("", "cases", "answers", "results", "diagnoses")
    for folder in (*(out / name for name in kept), *(out / "diagnoses").glob("*/")):
        drop_drafts(folder)


def _refuse_another_run(out: Path, machine: str, seed: int, cases: int) -> None:
    if machine not in MACHINES:
        raise InputError(
            "--machine", f"unknown machine {machine!r}", f"one of {', '.join(MACHINES)}"
        )
    if not (out / "sealed.json").exists():
        return
    found = json.loads((out / "sealed.json").read_text())
    held = (found.get("machine", "drive"), found["seed"], len(found["answers"]))
    if held != (machine, seed, cases):
        raise InputError(
            out,
            f"holds a run of {held[2]} cases of {held[0]}, seed {held[1]}",
            f"{cases} cases of {machine}, seed {seed}",
            "Choose another folder, or repeat with the same numbers to resume.",
        )


def _finished(path: Path) -> bool:
    return path.exists() and json.loads(path.read_text())["error"] is None


def _opened(out: Path, name: str) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((out / "answers" / f"{name}.json").read_text())
    return content


def _result(out: Path, name: str) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((out / "results" / f"{name}.json").read_text())
    return content


def _hash(salt: str, answer: dict[str, Any]) -> str:
    text = json.dumps(answer, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256((salt + text).encode()).hexdigest()


def _digest_logs(folder: Path) -> str:
    digest = hashlib.sha256()
    for path in sorted(folder.iterdir()):
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()
