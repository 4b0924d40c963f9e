"""Workspace: how far does the PepperMill-Carrier's gripper turn at each place of one height?

python -m gapscope.analysis.examples.workspace FOLDER
"""

import sys
from pathlib import Path

import numpy as np

from ...models.pmc.geometry import Geometry
from ..figures import plt
from ..files import output_folder
from ..pmc import reach


def main(folder: Path, height: float = 0.0) -> float:
    """Share of the carriages' square where it turns fully at ``height`` [m]; draws ``workspace.png``."""
    geometry = Geometry()
    places = reach.cell_centres(geometry, 120)
    turns = reach.rotatability(places[:, None], places, height, geometry) / (2.0 * np.pi)
    figure, axes = plt.subplots(figsize=(6, 5), layout="constrained")
    drawn = axes.pcolormesh(
        1e3 * places, 1e3 * places, turns.T, cmap="cividis", vmin=0.0, vmax=geometry.turns
    )
    figure.colorbar(drawn, label="rotation the gripper can make [turns]")
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("y [mm]")
    axes.set_aspect("equal")
    full = float(np.mean(turns > geometry.turns - 1e-9))
    axes.set_title(f"z = {1e3 * height:.0f} mm: {full:.0%} of the square turns fully", loc="left")
    figure.savefig(output_folder(folder) / "workspace.png", dpi=120)
    plt.close(figure)
    return full


if __name__ == "__main__":
    sys.stdout.write(f"{main(Path(sys.argv[1])):.1%} turns fully\n")
