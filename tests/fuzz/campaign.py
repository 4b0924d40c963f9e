"""Many mutated inputs in child processes that may crash, hang or swell without harm to the campaign."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
import traceback
from collections import Counter
from pathlib import Path

from .targets import TARGETS, attempt, write_seeds

HANG = 10  # [s] of processor time: the wall clock depends on who else is on the machine
STUCK = 300  # [s] of wall time, for what waits instead of computing
SWELL = 1 << 30  # bytes of peak memory of a child above what it had before its first input
CAP = 4 << 30  # bytes of address space a child may take beyond its start, to protect the machine
BATCH = 2500


def run(count: int, folder: Path, first: int = 0) -> dict:
    """Try ``count`` inputs; outcomes by target, and every failure with what it takes to repeat it."""
    subprocess.run([*_child(), "seeds", str(folder)], check=True)
    outcomes: Counter[str] = Counter()
    failures: list[dict] = []
    number = first
    while number < first + count:
        stop = min(first + count, number - number % BATCH + BATCH)
        done = subprocess.run(
            [*_child(), "batch", str(folder), str(number), str(stop)],
            capture_output=True,
            text=True,
        )
        lines = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
        for line in lines:
            outcomes[f"{line['target']}: {line['outcome']}"] += 1
            if line["outcome"] not in ("ok", "refused"):
                failures.append(line)
        number = lines[-1]["number"] + 1 if lines else number
        if done.returncode:
            target = TARGETS[number % len(TARGETS)]
            outcomes[f"{target}: died"] += 1
            failures.append({"number": number, "target": target, "outcome": "died",
                             "what": f"exit {done.returncode}: {done.stderr[-500:]}"})  # fmt: skip
            number += 1
    return {"count": count, "outcomes": dict(sorted(outcomes.items())), "failures": failures}


def _child() -> list[str]:
    return [sys.executable, "-X", "faulthandler", "-c",
            f"import sys; sys.path.insert(0, {str(Path(__file__).parents[1])!r}); "
            "from fuzz import campaign; campaign.main()"]  # fmt: skip


def main() -> None:
    """Entry of the child processes, and ``python -m fuzz.campaign run COUNT FOLDER [FIRST]``."""
    command, *rest = sys.argv[1:]
    if command == "seeds":
        write_seeds(Path(rest[0]) / "seeds")
    elif command == "batch":
        _batch(Path(rest[0]), int(rest[1]), int(rest[2]))
    else:
        found = run(int(rest[0]), Path(rest[1]), int(rest[2]) if rest[2:] else 0)
        sys.stdout.write(json.dumps(found, indent=1) + "\n")


def _batch(folder: Path, first: int, stop: int) -> None:
    for number in (signal.SIGPROF, signal.SIGALRM):
        signal.signal(number, _hang)
    resource.setrlimit(resource.RLIMIT_AS, (_address_space() + CAP, resource.RLIM_INFINITY))
    _warm_up(folder)
    for number in range(first, stop):
        target = TARGETS[number % len(TARGETS)]
        before = _peak()
        start = time.process_time()
        try:
            signal.setitimer(signal.ITIMER_PROF, HANG)
            signal.alarm(STUCK)
            outcome, what = (
                attempt(target, folder / "seeds", number, folder / f"scratch-{os.getpid()}"),
                "",
            )
        except BaseException as error:
            outcome = "hang" if isinstance(error, Hang) else "traceback"
            what = "".join(traceback.format_exception(error))[-1500:]
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
            signal.alarm(0)
        if _peak() - before > SWELL:
            outcome, what = "swell", f"{(_peak() - before) / 2**20:.0f} MB"
        line = {"number": number, "target": target, "outcome": outcome, "what": what,
                "seconds": round(time.process_time() - start, 3), "peak_MB": _peak() >> 20}  # fmt: skip
        sys.stdout.write(json.dumps(line) + "\n")
        sys.stdout.flush()


class Hang(BaseException):
    """An input took longer than HANG or STUCK."""


def _hang(number: int, frame: object) -> None:
    raise Hang


def _warm_up(folder: Path) -> None:
    """Import and compile what the targets need, so that an input pays for itself only."""
    for target in (
        "log.parquet",
        "log.h5",
        "log.mcap",
        "log.bag",
        "log.mat",
        "config",
        "pmc-config",
        "run.csv",
    ):
        try:
            attempt(target, folder / "seeds", 0, folder / f"scratch-{os.getpid()}")
        except Exception:
            continue


def _peak() -> int:
    """Peak memory [bytes] of this process and of its largest child, such as the reader of MATLAB files."""
    who = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(resource.getrusage(one).ru_maxrss for one in who) * 1024


def _address_space() -> int:
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[0]) * resource.getpagesize()


if __name__ == "__main__":
    main()
