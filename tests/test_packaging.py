"""The wheel holds every package that is on disk, and nothing is imported from the checkout."""

import tomllib
from pathlib import Path

import pytest

import gapscope.models

ROOT = Path(__file__).resolve().parent.parent
ROOMS = ("models", "systems", "diagrams", "analysis")


def test_pyproject_lists_every_package_on_disk():
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    on_disk = [
        "gapscope." + ".".join(init.parent.relative_to(ROOT).parts)
        for room in ROOMS
        for init in (ROOT / room).rglob("__init__.py")
    ]
    assert sorted(listed) == sorted(on_disk)


def test_tests_run_against_the_installed_package():
    assert not Path(gapscope.models.__file__).is_relative_to(ROOT / "models")


@pytest.mark.parametrize("room", ROOMS)
def test_no_absolute_import_of_a_room(room):
    """``import systems.x`` works by accident from the repo root and makes a second copy of it."""
    sources = [p for r in (*ROOMS, "tests") for p in (ROOT / r).rglob("*.py")]
    offenders = [
        f"{path.relative_to(ROOT)}: {line}"
        for path in sources
        for line in path.read_text().splitlines()
        if line.startswith((f"import {room}", f"from {room}"))
    ]
    assert offenders == []
