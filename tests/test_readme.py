"""Every command and code block of the READMEs runs."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
READMES = [
    ROOT / "README.md", ROOT / "analysis" / "CONTRIBUTING.md",
    ROOT / "analysis" / "gap" / "effects" / "README.md", ROOT / "analysis" / "rig" / "README.md",
]  # fmt: skip


def blocks():
    for readme in READMES:
        for i, (language, text) in enumerate(BLOCK.findall(readme.read_text())):
            if language == "yaml":  # settings of the rig: tests/analysis/rig/test_rig_readme.py
                continue
            yield pytest.param(language, text, id=f"{readme.parent.name}-{language}-{i}")


@pytest.mark.parametrize(("language", "text"), list(blocks()))
def test_block_runs(language, text, tmp_path):
    binaries = Path(sys.executable).parent
    environment = {**os.environ, "PATH": f"{binaries}{os.pathsep}{os.environ['PATH']}"}
    command = {"sh": ["bash", "-euc", text], "python": [sys.executable, "-c", text]}[language]
    done = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("target", re.findall(r"^    make (\w+)", READMES[0].read_text(), re.M))
def test_make_target_exists(target):
    done = subprocess.run(
        ["make", "-n", target], cwd=ROOT, capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr


def test_every_command_of_the_table_exists():
    named = re.findall(r"^\| `gapscope (\w[\w-]*(?: [a-z][\w-]*)?)", READMES[0].read_text(), re.M)
    for words in named:
        known = [w for w in words.split() if w not in ("thesis-c-drive",)]
        done = subprocess.run(
            [Path(sys.executable).parent / "gapscope", *known, "--help"],
            capture_output=True, text=True, timeout=60,
        )  # fmt: skip
        assert done.returncode == 0, f"{words}: {done.stderr}"
    assert named


@pytest.mark.parametrize("readme", READMES, ids=lambda path: path.parent.name)
def test_links_and_pictures_exist(readme):
    for target in re.findall(r"\]\(([^)#]+)\)", readme.read_text()):
        assert target.startswith("https://") or (readme.parent / target).exists(), target
