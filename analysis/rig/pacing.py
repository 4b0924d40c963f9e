"""Real time: the rig's samples in step with the clock, a burst every few milliseconds."""

import threading
import time

from .controller import Rig
from .states import State

BURST = 0.01  # between two bursts [s]; a sleep is not finer on every system
BEHIND = 0.5  # beyond this the clock is set anew, and counted [s]


class Pacer(threading.Thread):
    """Ticks a rig at its sample time until it is off; ``lock`` is held during a burst.

    ``late`` is the worst delay of a burst [s], ``resets`` how often the computer could not keep up.
    """

    def __init__(self, rig: Rig, lock: threading.Lock) -> None:
        super().__init__(name="pacer", daemon=True)
        self._rig, self._lock = rig, lock
        self.late, self.resets = 0.0, 0
        self.error: BaseException | None = None

    def run(self) -> None:
        """Tick until the rig is off and stands."""
        try:
            self._run()
        except BaseException as error:  # shown by who started the thread
            self.error = error
            raise

    def _run(self) -> None:
        dt = self._rig.machine.layout.dt
        with self._lock:
            self._rig.tick()  # compiles what is not compiled yet
        began, done = time.perf_counter(), 0
        while not (self._rig.state is State.OFF and self._rig.standing):
            due = int((time.perf_counter() - began) / dt)
            behind = (due - done) * dt - BURST
            if behind > BEHIND:
                self.resets += 1
                began, done = time.perf_counter(), 0
                continue
            self.late = max(self.late, behind)
            with self._lock:
                for _ in range(due - done):
                    self._rig.tick()
            done = due
            time.sleep(max(began + (done + BURST / dt) * dt - time.perf_counter(), 0.0))
