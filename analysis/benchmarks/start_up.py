"""Group ``start-up``: wall time of ``gapscope --help`` in a new process, beside the bare interpreter."""

import subprocess
import sys
from collections.abc import Sequence

from .rounds import Contender, Group, measure, rows

NAME = "start-up"
BARE, HELP, NUMPY = "bare Python", "gapscope --help", "import numpy"
_MAIN = "from gapscope.analysis.cli import main; main()"
COMMANDS = {
    BARE: ("-c", "pass"),
    NUMPY: ("-c", "import numpy"),
    HELP: ("-c", _MAIN, "--help"),
}


def start_up(rounds: int) -> Group:
    """Time one new process of each command over ``rounds`` interleaved rounds, files in the page cache."""
    contenders = [_process(name, command) for name, command in COMMANDS.items()]
    checks = [_check(contender) for contender in contenders]
    seconds, repeats = measure(contenders, rounds)
    return Group(
        name=NAME,
        task="a new process from start to exit, files in the page cache",
        rounds=rounds,
        reference=BARE,
        agreement="exit code 0; the help names the command `diagnose`",
        rows=rows(contenders, seconds, repeats, checks, BARE),
    )


def _process(name: str, command: Sequence[str]) -> Contender:
    def run() -> subprocess.CompletedProcess[str]:
        return subprocess.run([sys.executable, *command], capture_output=True, text=True)

    return Contender(name=name, run=run)


def _check(contender: Contender) -> tuple[str, bool]:
    done = contender.run()
    right = done.returncode == 0 and ("diagnose" in done.stdout or contender.name != HELP)
    return f"exit code {done.returncode}", right
