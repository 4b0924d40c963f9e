"""Skeletons in Meshcat: drawn once, then moved, by sliders or by a recording."""

import logging
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.geometry import Cylinder, Meshcat, MeshcatParams, Rgba, Sphere
from pydrake.math import RigidTransform, RotationMatrix

from .skeletons import Floats, Skeleton

# Okabe and Ito, told apart by colour-blind eyes.
STEEL = Rgba(0.35, 0.37, 0.40, 1.0)
BLUE, VERMILION = Rgba(0.0, 0.447, 0.698, 0.55), Rgba(0.835, 0.369, 0.0, 0.3)
STOP = "stop"


def open_meshcat() -> Meshcat:
    """A server on this machine only."""
    logging.getLogger("drake").setLevel(logging.WARNING)
    meshcat = Meshcat(MeshcatParams(host="localhost", show_stats_plot=False))
    meshcat.SetProperty("/Grid", "visible", False)
    meshcat.SetProperty("/Axes", "visible", False)
    for end in ("top_color", "bottom_color"):
        meshcat.SetProperty("/Background", end, [0.96, 0.97, 0.98])
    return meshcat


class Drawing:
    """One copy of a machine in a scene, under the path ``name``; ``swell`` >= 1 thickens it about its axes."""

    def __init__(
        self, meshcat: Any, machine: Skeleton, name: str, colour: Rgba, swell: float = 1.0
    ) -> None:
        self._meshcat, self._machine, self._name = meshcat, machine, name
        placed = machine.place(machine.start)
        for rod, radius in machine.rods.items():
            length = float(np.linalg.norm(placed[rod][1] - placed[rod][0]))
            meshcat.SetObject(
                self._path(rod),
                Cylinder(swell * radius, length + 2.0 * (swell - 1.0) * radius),
                colour,
            )
        for ball, radius in machine.balls.items():
            meshcat.SetObject(self._path(ball), Sphere(swell * radius), colour)
        self.move(machine.start)

    def _path(self, part: str) -> str:
        return f"{self._name}/{part}"

    def move(self, values: Floats, at: float | None = None) -> bool:
        """Put every part in its place, at time ``at`` [s] of a recording if given; False, and no move, out of reach."""
        placed = self._machine.place(values)
        if not all(np.isfinite(part).all() for part in placed.values()):
            return False
        for rod in self._machine.rods:
            start, end = placed[rod]
            turned = RotationMatrix.MakeFromOneVector(end - start, 2)
            self._set(rod, RigidTransform(turned, 0.5 * (start + end)), at)
        for ball in self._machine.balls:
            self._set(ball, RigidTransform(placed[ball]), at)
        return True

    def _set(self, part: str, pose: RigidTransform, at: float | None) -> None:
        if at is None:
            self._meshcat.SetTransform(self._path(part), pose)
        else:
            self._meshcat.SetTransform(self._path(part), pose, at)


def look(meshcat: Any, machine: Skeleton) -> None:
    """Point the camera at the machine."""
    meshcat.SetCameraPose(np.array(machine.camera), np.array(machine.centre))


def still_page(machine: Skeleton) -> str:
    """Self-contained page with the machine in its starting posture, to turn and zoom."""
    meshcat = open_meshcat()
    Drawing(meshcat, machine, machine.name, STEEL)
    look(meshcat, machine)
    return str(meshcat.StaticHtml())


def slide(
    machine: Skeleton,
    opened: Callable[[str], None],
    *,
    meshcat: Any = None,
    pause: float = 0.03,
) -> int:
    """Show the machine with a slider per coordinate until its stop button is pressed; returns the moves made.

    ``opened`` is told the page's address. A posture out of reach is not shown; the machine waits at the last one.
    """
    meshcat = meshcat or open_meshcat()
    drawing = Drawing(meshcat, machine, machine.name, STEEL)
    look(meshcat, machine)
    labels = [f"{c.name} [{c.unit}]" for c in machine.coordinates]
    for label, c in zip(labels, machine.coordinates):
        step = (c.high - c.low) / 1000.0
        meshcat.AddSlider(label, c.low, c.high, step, c.start)
    meshcat.AddButton(STOP, "Escape")
    opened(str(meshcat.web_url()))
    before, moves = machine.start, 0
    while not meshcat.GetButtonClicks(STOP):
        values = np.array([meshcat.GetSliderValue(label) for label in labels])
        if not np.array_equal(values, before):
            moves += drawing.move(values)
            before = values
        time.sleep(pause)
    return moves
