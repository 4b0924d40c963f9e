"""The command line starts fast, knows its version, and turns bad input into one line."""

import json
import subprocess
import sys
import time
from importlib.metadata import version
from pathlib import Path

import pytest
from typer import Context
from typer.main import get_command
from typer.testing import CliRunner

from gapscope.analysis.cli import app
from gapscope.analysis.errors import InputError

GAPSCOPE = Path(sys.executable).parent / "gapscope"
# All that ``gapscope --help`` may load beside the standard library: the command line and what it prints with.
LIGHT = {
    "gapscope", "typer", "click", "rich", "shellingham", "pygments", "markdown_it", "mdurl", "annotated_doc",
    "typing_extensions",
}  # fmt: skip
MOST_MODULES = 450  # standard library included


def run(*arguments):
    return subprocess.run([GAPSCOPE, *arguments], capture_output=True, text=True, timeout=120)


def test_version():
    assert run("--version").stdout.strip() == f"gapscope {version('gapscope')}"


def imported(code):
    """Top-level names outside the standard library, and the number of modules, after ``code``."""
    report = (
        "\nimport sys, json; names = {m.split('.')[0] for m in sys.modules}"
        "; print(json.dumps([sorted(names - sys.stdlib_module_names), len(sys.modules)]))"
    )
    done = subprocess.run([sys.executable, "-c", code + report], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    names, count = json.loads(done.stdout)
    return set(names), count


def test_help_imports_nothing_heavy():
    """The budget is in imports, not seconds: seconds depend on who else is on the machine."""
    code = (
        "from gapscope.analysis.cli import app; from typer.testing import CliRunner; "
        "assert CliRunner().invoke(app, ['--help']).exit_code == 0"
    )
    bare, _ = imported("")  # what the site has loaded already
    names, count = imported(code)
    assert names - bare <= LIGHT
    assert count < MOST_MODULES


def test_the_budget_sees_a_heavy_import():
    bare, _ = imported("")
    names, count = imported("import scipy.optimize")
    assert not names - bare <= LIGHT
    assert count > MOST_MODULES


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


def commands(command):
    """Every command below ``command``, itself where it has none."""
    if not hasattr(command, "commands"):
        yield command
    for below in getattr(command, "commands", {}).values():
        yield from commands(below)


def test_help_shows_what_stands_in_brackets():
    """Units and names of extras, which markup would take for styles."""
    shown = CliRunner().invoke(app, ["workspace", "pmc", "--help"]).output
    assert "gapscope[cluster]" in shown
    shown = CliRunner().invoke(app, ["import", "--help"], env={"COLUMNS": "120"}).output
    assert "[s]" in shown


def test_every_command_refuses_an_unwritable_out_before_it_begins(tmp_path):
    """By the option alone: the command behind it is not run."""
    root = get_command(app)
    (tmp_path / "taken").write_text("")
    below = str(tmp_path / "taken" / "below")
    outs = [(command, option)
            for command in commands(root)
            for option in command.params if option.name == "out"]  # fmt: skip
    assert len(outs) > 20
    for command, option in outs:
        with pytest.raises(InputError, match="not usable as a folder"):
            option.process_value(Context(command), below)
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


def test_out_is_refused_before_the_log_set_is_read(tmp_path):
    (tmp_path / "taken").write_text("")
    done = run("diagnose", str(tmp_path / "missing"), "--out", str(tmp_path / "taken"))
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"gapscope: {tmp_path / 'taken'}: not usable as a folder")
