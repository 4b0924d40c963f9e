"""The command line starts fast, knows its version, and turns bad input into one line."""

import subprocess
import sys
import time
from importlib.metadata import version
from pathlib import Path

GAPSCOPE = Path(sys.executable).parent / "gapscope"
HEAVY = ("pydrake", "numba", "scipy", "matplotlib", "numpy")


def run(*arguments):
    return subprocess.run([GAPSCOPE, *arguments], capture_output=True, text=True, timeout=120)


def test_version():
    assert run("--version").stdout.strip() == f"gapscope {version('gapscope')}"


def test_help_imports_nothing_heavy():
    """The budget is in imports, not seconds: seconds depend on who else is on the machine."""
    code = (
        "import sys; from gapscope.analysis.cli import app; from typer.testing import CliRunner; "
        "assert CliRunner().invoke(app, ['--help']).exit_code == 0; "
        f"sys.exit(','.join(m for m in {HEAVY} if m in sys.modules) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr


def test_help_is_quick_beside_bare_python():
    def seconds(*command):
        times = []
        for _ in range(3):
            start = time.perf_counter()
            subprocess.run(command, capture_output=True, check=True)
            times.append(time.perf_counter() - start)
        return min(times)

    typer = seconds(sys.executable, "-c", "import typer, rich.console, rich.table, rich.panel")
    assert seconds(GAPSCOPE, "--help") < 3.0 * typer


def test_unusable_input_is_one_line_and_exit_code_2(tmp_path):
    done = run("diagnose", str(tmp_path), "--out", str(tmp_path / "out"))
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert done.stderr.startswith("gapscope: ")
    assert not (tmp_path / "out").exists()
