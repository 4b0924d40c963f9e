"""The workspace as one self-contained 3-D page: surfaces, largest bodies and the industry's cycle.

Drake's Meshcat writes the page; every part can be switched on and off in its scene tree.
"""

import logging

import numpy as np

from ...models.pmc.cycle import IndustryCycle
from . import reach
from .workspace import Study


def page(result: Study) -> str:
    """HTML of about 2 MB without references to other files."""
    from pydrake.geometry import Box, Cylinder, Meshcat, MeshcatParams, Rgba
    from pydrake.math import RigidTransform

    # Meshcat announces a server that nobody needs here.
    logging.getLogger("drake").setLevel(logging.WARNING)
    meshcat = Meshcat(MeshcatParams(host="localhost", show_stats_plot=False))
    geometry = result.geometry
    x = np.linspace(geometry.carriage_min, geometry.carriage_max, 61)
    xs, ys = np.asfortranarray(np.meshgrid(x, x, indexing="ij"))
    low, high = reach.reachable_surfaces(xs, ys, geometry)
    for name, z, colour in (
        ("lowest", low, Rgba(0.0, 0.45, 0.70, 0.5)),
        ("highest", high, Rgba(0.84, 0.37, 0.0, 0.5)),
    ):
        meshcat.PlotSurface(f"reachable/{name}", xs, ys, np.asfortranarray(z), colour)
    cuboid, cylinder = result.bodies["full_range"].cuboid, result.bodies["full_range"].cylinder
    edges = (cuboid.x, cuboid.y, cuboid.z)
    meshcat.SetObject(
        "largest cuboid of all turns",
        Box(*(high - low for low, high in edges)),
        Rgba(0.0, 0.62, 0.45, 0.25),
    )
    meshcat.SetTransform(
        "largest cuboid of all turns", RigidTransform([0.5 * (low + high) for low, high in edges])
    )
    bottom, top = cylinder.z
    meshcat.SetObject(
        "largest cylinder of all turns",
        Cylinder(cylinder.radius, top - bottom),
        Rgba(0.8, 0.47, 0.65, 0.35),
    )
    meshcat.SetTransform(
        "largest cylinder of all turns", RigidTransform([*cylinder.centre, 0.5 * (bottom + top)])
    )
    cycle = IndustryCycle(placement=result.cycles[0][0])
    path = cycle.sample(np.linspace(0.0, 0.5 * cycle.period, 300))[0][:, :3].T
    meshcat.SetLine("industry cycle", np.asfortranarray(path), 4.0, Rgba(0.0, 0.0, 0.0, 1.0))
    meshcat.SetCameraPose(np.array([-0.20, -0.13, 0.1]), np.array([0.3, 0.3, -0.18]))
    return str(meshcat.StaticHtml())
