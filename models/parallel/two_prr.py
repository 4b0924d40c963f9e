r"""2-PRR with a parallelogram, in its two slider positions (Roldan, section 6.1 and appendix B.3).

Slider 1 is at x = rho_1, slider 2 at x = a - rho_2; the platform hangs below, at height -L sin(alpha), by bars 3
and 4 (parallel, d apart, from slider 1) and bar 5 (from slider 2, to bar 4's joint: assumed, Fig. 6.2 is not
printed in text). alpha is the slope of bars 3 and 4; bar 5 mirrors it.

Corrected here: (B.62) and (B.65) have the second entry of the first row -1/4, for -3/4: a bar's centre is the mean
of slider and platform, (B.66) has it right, and only so are (6.27), (6.28) m1 - m5/2 and m2 + m5/2.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .energy import Floats, Motion

BODIES = ("slider1", "slider2", "bar3", "bar4", "bar5", "platform")


@dataclass(frozen=True, kw_only=True)
class TwoPRR:
    """Printed dimensions and theoretical masses (Table 6.2). Raises ValueError unless they are positive."""

    span: float = 1.3  # a, between the origins of the sliders [m]
    bar: float = 0.654  # L [m]
    offset: float = 0.095  # d, between the joints of the parallelogram [m]
    masses: tuple[float, ...] = (23.9744, 23.5028, 1.0267, 1.0267, 1.0267, 2.7750)  # BODIES [kg]
    bar_inertias: tuple[float, float, float] = (0.0366, 0.0366, 0.0366)  # [kg m^2]
    weight: float = 9.81  # gravity along -y [m/s^2]

    def __post_init__(self) -> None:
        for name in ("span", "bar", "offset"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} is {getattr(self, name)}; expected a length above 0 m")
        if len(self.masses) != 6 or min(*self.masses, *self.bar_inertias) < 0.0:
            raise ValueError(f"masses are {self.masses}; expected six of at least 0 kg")

    @property
    def body_inertias(self) -> Floats:
        """Of BODIES (6,) [kg m^2]; sliders and platform do not turn."""
        return np.array([0.0, 0.0, *self.bar_inertias, 0.0])


def slope(sliders: ArrayLike, machine: TwoPRR) -> Floats:
    """Slope alpha (...) [rad] of bars 3 and 4 at slider positions (..., 2) [m]; NaN where the loop is open."""
    q = np.asarray(sliders, dtype=float)
    reach = 0.5 * (machine.span - machine.offset - q[..., 0] - q[..., 1])
    with np.errstate(invalid="ignore"):
        return np.asarray(np.arccos(reach / machine.bar))


def forward(sliders: ArrayLike, machine: TwoPRR) -> Floats:
    """Joint of bars 4 and 5 on the platform (..., 2) [m], platform below the sliders."""
    q = np.asarray(sliders, dtype=float)
    x = 0.5 * (q[..., 0] + machine.offset + machine.span - q[..., 1])
    return np.stack([x, -machine.bar * np.sin(slope(q, machine))], axis=-1)


def inverse(platform: ArrayLike, machine: TwoPRR, modes: tuple[int, int] = (1, 1)) -> Floats:
    """Slider positions (..., 2) [m] at platform positions (..., 2); mode +1 has that slider outside of it."""
    p = np.asarray(platform, dtype=float)
    with np.errstate(invalid="ignore"):
        reach = np.sqrt(machine.bar**2 - p[..., 1] ** 2)
    return np.stack(
        [
            p[..., 0] - machine.offset - modes[0] * reach,
            machine.span - p[..., 0] - modes[1] * reach,
        ],
        axis=-1,
    )


def motion(sliders: ArrayLike, rates: ArrayLike, machine: TwoPRR) -> Motion:
    """Motion of BODIES at slider positions and rates (..., 2) (B.60-B.67)."""
    q, v = np.asarray(sliders, dtype=float), np.asarray(rates, dtype=float)
    alpha = slope(q, machine)
    by = 0.5 / (machine.bar * np.sin(alpha))  # B of (B.64)
    fall = 0.5 / np.tan(alpha)  # A of (B.63)
    rate = by * (v[..., 0] + v[..., 1])
    turn = -rate * rate / np.tan(alpha)
    drop = machine.bar * rate * rate * np.sin(alpha) - machine.bar * np.cos(alpha) * turn
    jacobian, drift = np.zeros((*alpha.shape, 6, 3, 2)), np.zeros((*alpha.shape, 6, 3))
    jacobian[..., 0, :] = (
        (1.0, 0.0),
        (0.0, -1.0),
        (0.75, -0.25),
        (0.75, -0.25),
        (0.25, -0.75),
        (0.5, -0.5),
    )
    for bar, sign in ((2, 1.0), (3, 1.0), (4, -1.0)):
        jacobian[..., bar, 1, :] = -0.5 * fall[..., None]
        jacobian[..., bar, 2, :] = sign * by[..., None]
        drift[..., bar, 1], drift[..., bar, 2] = 0.5 * drop, sign * turn
    jacobian[..., 5, 1, :] = -fall[..., None]
    drift[..., 5, 1] = drop
    return Motion(jacobian, drift)
