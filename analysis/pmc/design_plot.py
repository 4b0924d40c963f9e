"""Figure of the design study: how much torque and workspace do other dimensions give?"""

from io import BytesIO

from matplotlib.figure import Figure

from .design import DesignStudy

BLUE, ORANGE, GREEN = "#0072B2", "#D55E00", "#009E73"


def png(result: DesignStudy) -> bytes:
    """The figure as PNG."""
    figure = Figure(figsize=(7.4, 4.8), layout="constrained")
    axes = figure.subplots()
    for front, colour, label in (
        (result.front, BLUE, "leads up to 40 mm"),
        (result.same_lead, GREEN, "lead of the prototype"),
    ):
        volume = [1e3 * m.volume for _, m in front]
        torque = [1e3 * m.torque for _, m in front]
        axes.plot(volume, torque, "o-", color=colour, label=f"Pareto front, {label}")
        for (geometry, _), x, y in zip(front, volume, torque):
            axes.annotate(
                f"r {1e3 * geometry.proximal:.0f}, l {1e3 * geometry.distal:.0f} mm",
                (x, y),
                xytext=(6, 6),
                textcoords="offset points",
                fontsize=7,
            )
    p = result.prototype
    axes.plot(1e3 * p.volume, 1e3 * p.torque, "s", color=ORANGE, label="prototype")
    axes.margins(x=0.25, y=0.15)
    axes.set(
        xlabel="reachable volume [l]",
        ylabel="gripper torque available everywhere [mN m]",
        title="Other dimensions of the PepperMill-Carrier, not taller than the prototype",
    )
    axes.legend(loc="lower left")
    image = BytesIO()
    figure.savefig(image, format="png", dpi=130)
    return image.getvalue()
