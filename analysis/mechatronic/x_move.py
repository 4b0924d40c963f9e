"""How far the X move's deviation hangs on what is not printed: its height, and feed-forward (Roldan, section 4.1.4)."""

import numpy as np
from scipy.optimize import brentq

from ...diagrams.five_bar_loop import FiveBarLoop
from ...models.paths import Line

PRINTED = 22.0  # [mm]
HEIGHTS = (
    0.70,
    0.80,
    0.90,
    1.00,
    1.05,
)  # where the whole move is in reach and keeps its working mode [m]


def deviation(path: Line, gain: float, feedforward: float) -> float:
    """Largest distance of the tool from a line along x [mm] where the joints lag by the position loop alone.

    ``gain`` k_v [1/s]; ``feedforward`` is a share of the joints' rate [-]. The velocity loop and all inside it count
    as instantaneous: within 0.1 mm of the diagram at the printed gain. NaN out of reach.
    """
    loop = FiveBarLoop()
    period = loop.position_period
    t = period * np.arange(int(path.profile.duration / period))
    wanted = np.array([loop.machine.inverse(x) for x in path.sample(t)[0]])
    rates = np.gradient(wanted, period, axis=0)
    joints = np.empty_like(wanted)
    joints[0] = wanted[0]
    for k in range(len(t) - 1):
        joints[k + 1] = joints[k] + period * (
            gain * (wanted[k] - joints[k]) + feedforward * rates[k]
        )
    return 1e3 * float(np.abs(loop.machine.forward(joints)[:, 1] - path.start[1]).max())


def by_height(path: Line, gain: float) -> dict[float, float]:
    """Deviation [mm] of the move at each of ``HEIGHTS`` [m], without feed-forward."""
    return {y: deviation(_at(path, y), gain, 0.0) for y in HEIGHTS}


def feedforward_as_printed(path: Line, gain: float) -> float:
    """Share of feed-forward at which the move deviates by the printed 22 mm."""
    return float(brentq(lambda f: deviation(path, gain, f) - PRINTED, 0.0, 1.0, xtol=1e-3))


def _at(path: Line, height: float) -> Line:
    return Line(
        start=(path.start[0], height), end=(path.end[0], height),
        feed=path.feed, acceleration=path.acceleration,
    )  # fmt: skip
