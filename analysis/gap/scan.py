"""Shapes that no list can hold, such as the period of a ripple, looked for in what a fit leaves.

At every value of the shape the effect is linear in its other parameters at zero. How far they would lower the loss of
a fit, its own parameters refitted to first order, is a spectrum over the shape; its highest peaks become forms in which
the shape is one more parameter.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.signal import find_peaks

from .effects import Form, Scan
from .hypothesis import Fit
from .machine import Array, RunData
from .prediction import STEP, Predictor, flatten

FOUND = 2  # peaks that become forms
MOST_SAMPLES = 8_000  # of all runs together that a spectrum is taken of
THIN = 3  # of so many values of a residual one counts: a peak needs no more
TOGETHER = 64  # values of the shape that are predicted at once
LEAST_FALL = 0.005  # of the loss, at a peak that is worth a form


class Spectra:
    """How much every shape of every effect that is looked for would lower the loss of a fit.

    What a shape does to the runs is predicted once, beside ``base``: beside another fit it differs in size more than
    in form.
    """

    def __init__(self, predictor: Predictor, base: Fit) -> None:
        runs, self._rows = _beginnings(predictor, base)
        self._scans = {
            scan.effect: (scan, _responses(predictor, base, scan, runs))
            for scan in _scans(predictor)
        }

    def forms_beside(self, parent: Fit) -> list[Form]:
        """Forms for the highest peaks of every effect that the fit has not."""
        forms: list[Form] = []
        for effect, (scan, _) in self._scans.items():
            if effect in parent.hypothesis.ids:
                continue
            falls = np.concatenate([[0.0], self.falls(effect, parent), [0.0]])
            peaks, _ = find_peaks(falls, height=LEAST_FALL)
            highest = peaks[np.argsort(falls[peaks])[::-1][:FOUND]]
            forms += [scan.form(float(scan.values[i - 1])) for i in highest]
        return forms

    def falls(self, effect: str, parent: Fit) -> Array:
        """Share of the parent's loss that the effect removes to first order at each value of its shape."""
        residual = parent.residual[self._rows][::THIN]
        basis = np.linalg.qr(parent.jacobian[self._rows][::THIN])[0]
        left = residual - basis @ (basis.T @ residual)
        falls = []
        for responses in self._scans[effect][1]:  # (moves, samples) of one shape
            part = responses - (responses @ basis) @ basis.T
            slope = part @ left
            falls.append(float(slope @ np.linalg.lstsq(part @ part.T, slope, rcond=1e-12)[0]))
        return np.array(falls) / max(float(np.sum(residual**2)), 1e-300)


def _responses(predictor: Predictor, base: Fit, scan: Scan, runs: Sequence[RunData]) -> Array:
    """What small amplitudes of the effect at each value of its shape do to the residuals beside ``base``.

    Array (values, amplitudes, thinned samples of the runs).
    """
    form = scan.form(float(scan.values[0]))
    hypothesis = base.hypothesis.with_form(form)
    free = hypothesis.free(predictor.machine)
    keys = tuple((effect, p.name) for effect, p in free)
    known = base.by_key()
    shape = keys.index((form.effect, scan.shape))
    still = np.array([known.get(key, 0.0) for key in keys])
    still[shape] = scan.values[0]
    moves = np.diag([STEP * p.scale for _, p in free])
    moves = moves[[i for i, key in enumerate(keys) if key[0] == form.effect and i != shape]]
    residual = flatten(predictor.residuals(hypothesis, [still], keys, runs)[0])[::THIN]
    responses = np.empty((scan.values.size, len(moves), residual.size))
    for first in range(0, scan.values.size, TOGETHER):
        values = scan.values[first : first + TOGETHER]
        points = np.repeat(still[None], len(values) * len(moves), axis=0)
        points += np.tile(moves, (len(values), 1))
        points[:, shape] = np.repeat(values, len(moves))
        moved = predictor.residuals(hypothesis, points, keys, runs)
        rows = np.array([flatten(r)[::THIN] for r in moved]) - residual
        responses[first : first + TOGETHER] = rows.reshape(len(values), len(moves), -1)
    return responses


def effects_looked_for(predictor: Predictor) -> set[str]:
    """Effects with a shape that the runs let one look for."""
    return {scan.effect for scan in _scans(predictor)}


def _scans(predictor: Predictor) -> list[Scan]:
    scans = predictor.machine.scans(predictor.runs)
    return [scan for scan in scans if scan.values.size > 2]


def _beginnings(predictor: Predictor, parent: Fit) -> tuple[list[RunData], Array]:
    """The runs, cut short where they are long, and the rows of the parent's residuals that this leaves."""
    most = max(MOST_SAMPLES // len(predictor.runs), 1)
    runs, rows, first = [], [], 0
    for run in predictor.runs:
        samples, n = run.position[run.window].shape
        begin = run.window.start or 0
        kept = min(samples, most)
        end = begin + kept
        window = slice(begin, end)
        runs.append(
            replace(run, position=run.position[:end], command=run.command[:end], window=window)
        )
        rows.append(first + np.arange(kept * n))
        first += samples * n
    return runs, np.concatenate(rows)
