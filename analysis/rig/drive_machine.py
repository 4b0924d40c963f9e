"""A machine whose plant is an n-shaft drive: C-drive and slider, sample by sample.

Plant and control law are those of the compiled loops (``models.drive_kernels``), called for one sample at a time on a
short history, whose last row is now.
"""

from typing import Any

import numpy as np

from ...models import drive, drive_kernels, encoder
from ...models.drive import Drive
from ...models.drive_kernels import LoopController
from .machine import Floats, Layout

HISTORY = 64  # samples kept: the longest delay of a command, and the rate over two samples


class DriveMachine:
    """Plant ``plant`` at its true position, with encoders, under the law ``law``."""

    substeps = 1  # of the plant in a sample

    def __init__(self, layout: Layout, plant: Drive, law: LoopController) -> None:
        self.layout = layout
        self.law = law
        self._plant = plant
        n = len(layout.motors)
        self._offset = np.zeros(n)  # true position less reading
        self._work = drive.work_arrays(n)
        self._q = np.zeros(n)
        self.brake()
        self._position, self._command, self._wanted, self._acceleration = (
            np.zeros((HISTORY, n)) for _ in range(4)
        )
        self.wake()

    def power_up(self, rng: np.random.Generator) -> None:
        """Stand somewhere between the switches, the encoders at zero; or on the mark, if it homes there."""
        if not self.layout.finds_switch:
            self._q = self.layout.home.copy()
            self.brake()
            self.preset(self._q)
            return
        axes = np.array(
            [
                rng.uniform(a.low + 0.2 * (a.high - a.low), a.high - 0.2 * (a.high - a.low))
                if a.switched
                else 0.0
                for a in self.layout.axes
            ]
        )
        self._q = self.layout.motor(axes)
        self.brake()
        self.preset(np.zeros(len(self._q)))

    def read(self) -> Floats:
        """Encoder readings (motors,) [unit]."""
        values = self._q - self._offset
        return np.array([encoder.read(value, self.layout.lsb) for value in values])

    def preset(self, motors: Floats) -> None:
        """Let the encoders read ``motors`` here, to whole counts."""
        self._offset = self._q - motors

    def true_axes(self) -> Floats:
        """Where the axes really are (axes,)."""
        return self.layout.axis(self._q)

    def wake(self) -> None:
        """Controller at rest at the present reading."""
        reading = self.read()
        self._memory = drive_kernels.initial_memory(self.law, reading)
        self._position[:] = self._wanted[:] = reading
        self._command[:] = self._acceleration[:] = 0.0

    def step(self, reference: Floats, acceleration: Floats) -> Floats:
        """Control and plant of one sample; the command (motors,)."""
        for history, value in (
            (self._wanted, reference),
            (self._acceleration, acceleration),
            (self._position, self.read()),
            (self._command, 0.0),
        ):
            history[:-1] = history[1:]
            history[-1] = value
        last, dt = HISTORY - 1, self.layout.dt
        drive_kernels.control_step(
            last, self._wanted, self._acceleration, self._position, self.law, dt, self._memory,
            self._command,
        )  # fmt: skip
        self._command[-1] += self._feed_forward(reference)
        self._load_plant()
        drive_kernels.advance(
            last, self._q, self._v, self._z, self._held, self._lag, self._torque, self._command,
            self._plant, dt, self.substeps, self._work,
        )  # fmt: skip
        return self._command[-1].copy()

    def _feed_forward(self, reference: Floats) -> Floats:
        """What the controller adds to its law (motors,); nothing for a drive alone."""
        return np.zeros(len(reference))

    def _load_plant(self) -> None:
        """Put what hangs on the shafts in the present posture into the plant; nothing for a drive alone."""

    def brake(self) -> None:
        """Stand still without power."""
        n, m = len(self._q), len(self._plant.element)
        self._v, self._torque, self._lag = np.zeros(n), np.zeros(n), np.zeros((2, n))
        self._z, self._held = np.zeros(m), np.zeros(m)


def checked_rate(rate: float, cycles: int, dt: float) -> Any:
    """Samples of ``cycles`` at ``rate`` [Hz] as times [s]; ValueError for impossible numbers."""
    if not 0.0 < rate <= 0.05 / dt:
        raise ValueError(f"rate is {rate} Hz; expected above 0 and at most {0.05 / dt:g} Hz")
    if not 1 <= cycles <= 100:
        raise ValueError(f"cycles is {cycles}; expected 1 to 100")
    return dt * np.arange(round(cycles / (rate * dt)))
