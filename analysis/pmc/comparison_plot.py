"""Figure of the controller comparison: who keeps height and angle, and what does the counterweight do?"""

from io import BytesIO

import numpy as np
from matplotlib.figure import Figure

from ...models.pmc.controllers import CONTROLLERS
from .comparison import CYCLES, Comparison

COLOURS = {"ts": "#0072B2", "pd": "#D55E00", "ct": "#009E73", "ra": "#CC79A7"}
NAMES = {
    "ts": "task-space PD (Table 5-10)",
    "pd": "joint PD",
    "ct": "computed torque",
    "ra": "resolved acceleration",
}


def png(result: Comparison) -> bytes:
    """The figure as PNG."""
    figure = Figure(figsize=(10.0, 6.4), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True)
    for column, weight in enumerate((True, False)):
        height, rotation = panels[:, column]
        for name in CONTROLLERS:
            run = result.runs[name, "industry", weight]
            last = slice(-(len(run.reference.time) // CYCLES), None)
            time = run.reference.time[last] - run.reference.time[last][0]
            errors = (run.poses - run.reference.poses)[last]
            height.plot(time, 1e3 * errors[:, 2], color=COLOURS[name], label=NAMES[name])
            rotation.plot(time, np.degrees(errors[:, 3]), color=COLOURS[name])
        height.set_title(f"{'with' if weight else 'without'} counterweight")
        height.set_ylabel("height error [mm]")
        rotation.set(ylabel="rotation error [°]", xlabel="time in the third cycle [s]")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    figure.suptitle("PepperMill-Carrier on the industry cycle")
    image = BytesIO()
    figure.savefig(image, format="png", dpi=130)
    return image.getvalue()
