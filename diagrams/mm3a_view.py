"""Three-dimensional replay of the MM3A in a web page, its tip path magnified to the scale of the steps."""

import logging

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Meshcat, MeshcatParams, MeshcatVisualizer, Rgba
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from ..models.mm3a import kinematics
from ..models.mm3a.arm import Arm
from ..models.mm3a.step_size import STEP_TIME
from ..systems.mm3a.plant import add_arm

FRAMES = 200  # of the replay at most
BLUE, VERMILION = Rgba(0.0, 0.447, 0.698, 1.0), Rgba(0.835, 0.369, 0.0, 1.0)


def replay_page(
    joints: NDArray[np.float64],
    wanted: NDArray[np.float64] | None = None,
    *,
    arm: Arm | None = None,
    magnification: float = 100.0,
) -> str:
    """Self-contained HTML of the arm playing ``joints`` (n, 3), one row per step time, upright base.

    Beside the tip its path is drawn ``magnification`` times enlarged about its start (vermilion) and
    so are the ``wanted`` tip positions (n, 3) in frame 0 [m] (blue). Raises ValueError for another shape.
    """
    if joints.ndim != 2 or joints.shape[1] != 3 or len(joints) < 2:
        raise ValueError(f"joints have shape {joints.shape}; expected (n, 3) with at least 2 rows")
    arm = arm or Arm()
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    add_arm(plant, arm)
    plant.Finalize()
    # Meshcat announces a server that nobody needs here.
    logging.getLogger("drake").setLevel(logging.WARNING)
    meshcat = Meshcat(MeshcatParams(host="localhost", show_stats_plot=False))
    visualizer = MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    start = np.array(kinematics.tip(joints[0], arm))
    tips = np.array([kinematics.tip(q, arm) for q in joints])
    for name, path, colour in (("tip path", tips, VERMILION), ("wanted path", wanted, BLUE)):
        if path is not None:
            meshcat.SetLine(name, (start + magnification * (path - start)).T, 2.0, colour)
    visualizer.StartRecording()
    for i in np.unique(np.linspace(0, len(joints) - 1, FRAMES).astype(int)):
        context.SetTime(i * STEP_TIME)
        plant.SetPositions(plant_context, joints[i])
        diagram.ForcedPublish(context)
    visualizer.StopRecording()
    visualizer.PublishRecording()
    meshcat.SetProperty("/Grid", "visible", False)
    meshcat.SetProperty("/Axes", "visible", False)
    meshcat.SetCameraPose([0.05, -0.07, 0.04], start)
    return str(meshcat.StaticHtml())
