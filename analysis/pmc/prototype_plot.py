"""Figure of the prototype's flaws: what do they spoil, and at which height?"""

from io import BytesIO

import numpy as np
from matplotlib.figure import Figure

from .prototype import PrototypeStudy

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
LABELS = {
    "joint_compliance": "joint compliance",
    "link_compliance": "link compliance",
    "calibration": "calibration offset",
    "unequal_loading": "unequal loading",
}


def png(result: PrototypeStudy) -> bytes:
    """The figure as PNG."""
    figure = Figure(figsize=(10.5, 4.4), layout="constrained")
    bars, heights = figure.subplots(1, 2)
    place = np.arange(len(result.spoiled))
    for i, name in enumerate(("across", "up", "rotation")):
        values = [100.0 * getattr(row, name) for row in result.spoiled]
        bars.bar(place + 0.27 * (i - 1), values, 0.25, color=COLOURS[i], label=name)
    bars.set_xticks(place, [LABELS[row.flaw].replace(" ", "\n") for row in result.spoiled])
    bars.set(
        ylabel="largest change [% of the motion asked]", title="On the industry cycle", yscale="log"
    )
    bars.legend()
    z = 1e3 * np.array(result.profile.z)
    for i, (name, label) in enumerate(
        (
            ("by_joints", "joint compliance"),
            ("by_links", "link compliance"),
            ("per_drive_error", "drive or calibration error"),
            ("by_loading", "unequal loading"),
        )
    ):
        curve = np.array(getattr(result.profile, name))
        heights.plot(z, curve / curve[-1], color=COLOURS[i], label=label)
    heights.set(
        xlabel="z on the middle axis [mm]",
        ylabel="rotation error relative to the top [-]",
        title="How strongly a flaw turns the gripper",
    )
    low, high = heights.get_ylim()
    heights.set_ylim(low, high + 0.3 * (high - low))  # room for the legend
    heights.legend(loc="upper right", ncols=2)
    image = BytesIO()
    figure.savefig(image, format="png", dpi=130)
    return image.getvalue()
