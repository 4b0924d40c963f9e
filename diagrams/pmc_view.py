"""The PepperMill-Carrier in three dimensions: a replay of joint motions that opens in any browser."""

import logging
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Meshcat, MeshcatParams, MeshcatVisualizer, Rgba
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from ..models.pmc import kinematics
from ..models.pmc.parameters import PMCParameters
from ..systems.pmc_plant import add_pmc, tree_positions

Floats = NDArray[np.float64]


def replay_html(
    time: Floats,
    joints: Floats,
    parameters: PMCParameters,
    *,
    reference: Floats | None = None,
    frames_per_second: float = 25.0,
) -> str:
    """Self-contained page (2 to 3 MB) with an animation of joints (n, 4) at times (n,) [s].

    The path of the PM's centre is drawn in blue, and where given that of the ``reference`` poses (n, 4) in black.
    """
    # Meshcat announces a server that nobody needs here.
    logging.getLogger("drake").setLevel(logging.WARNING)
    meshcat = Meshcat(MeshcatParams(host="localhost", show_stats_plot=False))
    publish(meshcat, time, joints, parameters, reference, frames_per_second)
    return str(meshcat.StaticHtml())


def publish(
    meshcat: Meshcat,
    time: Floats,
    joints: Floats,
    parameters: PMCParameters,
    reference: Floats | None = None,
    frames_per_second: float = 25.0,
) -> None:
    """Put the same animation into a running Meshcat, to be watched live at ``meshcat.web_url()``."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    add_pmc(plant, parameters, closed=False)
    plant.Finalize()
    MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat)
    diagram: Any = builder.Build()
    context = diagram.CreateDefaultContext()
    _draw_path(meshcat, "path", kinematics.forward(joints, parameters.geometry), Rgba(0, 0.45, 0.7))
    if reference is not None:
        _draw_path(meshcat, "reference", reference, Rgba(0, 0, 0))
    meshcat.SetCameraPose(np.array([0.95, 0.80, 0.3]), np.array([0.2, 0.2, -0.1]))
    meshcat.SetProperty("/Grid", "visible", False)
    every = max(1, round(1.0 / (frames_per_second * (time[1] - time[0]))))
    meshcat.StartRecording(frames_per_second=frames_per_second)
    for t, w in zip(time[::every], joints[::every]):
        context.SetTime(float(t))
        plant.SetPositions(
            plant.GetMyMutableContextFromRoot(context),
            tree_positions(w, plant, parameters.geometry),
        )
        diagram.ForcedPublish(context)
    meshcat.StopRecording()
    meshcat.PublishRecording()


def _draw_path(meshcat: Meshcat, name: str, poses: Floats, colour: Rgba) -> None:
    points = poses[:: max(1, len(poses) // 500), :3].T
    meshcat.SetLine(name, np.asfortranarray(points), 3.0, colour)
