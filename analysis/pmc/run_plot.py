"""Figure of one run of the PepperMill-Carrier: how far off is the gripper, and what do the motors do?"""

from io import BytesIO

import numpy as np
from matplotlib.figure import Figure

from ...diagrams.pmc_loop import PMCLoopConfig
from ...models.pmc.simulation import Run

# Okabe and Ito's colours.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")


def png(run: Run, config: PMCLoopConfig) -> bytes:
    """The figure as PNG."""
    figure = Figure(figsize=(8.0, 7.4), layout="constrained")
    position, rotation, torque = figure.subplots(3, 1, sharex=True)
    time, errors = run.reference.time, run.poses - run.reference.poses
    for i, name in enumerate("xyz"):
        position.plot(time, 1e3 * errors[:, i], color=COLOURS[i], label=name)
    position.set_ylabel("position error [mm]")
    position.legend(ncols=3, loc="upper right")
    rotation.plot(time, np.degrees(errors[:, 3]), color=COLOURS[3])
    rotation.set_ylabel("rotation error [°]")
    for i, name in enumerate(("left 1", "right 1", "left 2", "right 2")):
        torque.plot(time, run.command[:, i], color=COLOURS[i], label=name, lw=0.9)
    for sign in (-1.0, 1.0):
        torque.axhline(sign * run.parameters.torque_limit, color="#666666", ls=":")
    torque.set(ylabel="motor torque [N m]", xlabel="time [s]")
    figure.legend(*torque.get_legend_handles_labels(), ncols=4, loc="outside lower center")
    weight = "" if run.parameters.counterweight.mass else ", no counterweight"
    figure.suptitle(f"PepperMill-Carrier, {config.controller} on the {config.cycle} cycle{weight}")
    image = BytesIO()
    figure.savefig(image, format="png", dpi=130)
    return image.getvalue()
