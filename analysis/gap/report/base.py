"""What every section is made from: the diagnosis and its predictions on the held-out runs."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..hypothesis import Fit
from ..machine import Array, RunData
from ..prediction import Predictor
from ..result import Diagnosis


class Material:
    """A diagnosis with the unexplained effort of any of its fits on the held-out runs."""

    def __init__(self, diagnosis: Diagnosis) -> None:
        self.diagnosis = diagnosis
        self.held_out: list[RunData] = [r for r in diagnosis.runs if r.use == "validate"]
        self._predictor = Predictor(diagnosis.machine, self.held_out)
        self._efforts: dict[int, list[Array]] = {}

    def efforts(self, fit: Fit) -> list[Array]:
        """Unexplained effort (samples, n) of every held-out run, on its window."""
        if id(fit) not in self._efforts:
            machine = self.diagnosis.machine
            residuals = self._predictor.residuals(fit.hypothesis, [fit.values], fit.keys)[0]
            self._efforts[id(fit)] = [
                machine.unexplained(r, run) for r, run in zip(residuals, self.held_out)
            ]
        return self._efforts[id(fit)]

    def rms(self, fit: Fit) -> float:
        """Rms unexplained effort over all held-out runs."""
        return rms(np.concatenate([e.ravel() for e in self.efforts(fit)]))


@dataclass(frozen=True, kw_only=True)
class Section:
    """A part of the page; ``key`` names its template and its anchor."""

    key: str
    title: str
    context: Callable[[Material], dict[str, Any]]


def rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
