"""How far X move and circles hang on what is not printed: height, and feed-forward (Roldan, section 4.1.4).

The joints lag by the position loop alone here; the velocity loop and all inside it count as instantaneous.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from ...diagrams.five_bar_loop import FiveBarLoop
from ...models.paths import Circle, Line

Floats = NDArray[np.float64]

TURN = 2.0 * np.pi
PRINTED = 22.0  # [mm]
HEIGHTS = (
    0.70,
    0.80,
    0.90,
    1.00,
    1.05,
)  # where the whole move is in reach and keeps its working mode [m]


def deviation(path: Line, gain: float, feedforward: float) -> float:
    """Largest distance of the tool from a line along x [mm]; within 0.1 mm of the diagram at the printed gain.

    ``gain`` k_v [1/s]; ``feedforward`` is a share of the joints' rate [-]. NaN out of reach.
    """
    _, _, joints = _lag(path, gain, feedforward)
    tool = FiveBarLoop().machine.forward(joints)
    return 1e3 * float(np.abs(tool[:, 1] - path.start[1]).max())


def joint_error(path: Line | Circle, gain: float, feedforward: float) -> float:
    """Largest error of a joint [motor turns]; within 0.01 of the diagram on the printed circles."""
    wanted, _, joints = _lag(path, gain, feedforward)
    return float(np.abs(wanted - joints).max()) / FiveBarLoop().axis.per_motor / TURN


def peak_rate(path: Line | Circle) -> float:
    """Largest rate of a motor [turns/s]."""
    _, rates, _ = _lag(path, 1.0, 0.0)
    return float(np.abs(rates).max()) / FiveBarLoop().axis.per_motor / TURN


def _lag(path: Line | Circle, gain: float, feedforward: float) -> tuple[Floats, Floats, Floats]:
    """Joints wanted, their rates, and the joints that lag behind them (samples, 2) [rad]."""
    loop = FiveBarLoop()
    period = loop.position_period
    t = period * np.arange(int(path.duration / period))
    wanted = np.array([loop.machine.inverse(x) for x in path.sample(t)[0]])
    rates = np.gradient(wanted, period, axis=0)
    joints = np.empty_like(wanted)
    joints[0] = wanted[0]
    for k in range(len(t) - 1):
        joints[k + 1] = joints[k] + period * (
            gain * (wanted[k] - joints[k]) + feedforward * rates[k]
        )
    return wanted, rates, joints


def by_height(path: Line, gain: float) -> dict[float, float]:
    """Deviation [mm] of the move at each of ``HEIGHTS`` [m], without feed-forward."""
    return {y: deviation(_at(path, y), gain, 0.0) for y in HEIGHTS}


def feedforward_as_printed(path: Line, gain: float) -> float:
    """Share of feed-forward at which the move deviates by the printed 22 mm."""
    return float(brentq(lambda f: deviation(path, gain, f) - PRINTED, 0.0, 1.0, xtol=1e-3))


def circle_feedforward(path: Circle, gain: float, printed: float) -> float:
    """Share of feed-forward at which a circle has the printed joint error [motor turns]."""
    return float(brentq(lambda f: joint_error(path, gain, f) - printed, 0.0, 1.0, xtol=1e-3))


def _at(path: Line, height: float) -> Line:
    return Line(
        start=(path.start[0], height), end=(path.end[0], height),
        feed=path.feed, acceleration=path.acceleration,
    )  # fmt: skip
