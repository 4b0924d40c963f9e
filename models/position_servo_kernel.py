"""Compiled loop over ``position_servo.py``: the angle that a reference asks for."""

from typing import Any

import numpy as np

from . import compilation, position_servo

compilation.register_laws(position_servo)


@compilation.kernel
def simulate(
    reference: Any, load: Any, servo: Any, dt: Any, substeps: Any, every: Any, out: Any
) -> None:
    """Angle ``out`` (k,) [rad] at every ``every``-th of the samples of a reference [rad] and load [rad].

    It starts at rest at out[0], whose value is the first measured angle. Reference and load (samples,)
    move evenly between samples ``dt`` seconds apart.
    """
    h = dt / substeps
    n = reference.size
    measured = out[0]
    q = (measured - servo.zero) / (1.0 + servo.scale_error)
    y, rate, asked = q, 0.0, reference[0]
    keep = 1.0
    if servo.lag > 0.0:
        keep = 1.0 - np.exp(-h / servo.lag)
    for k in range(n - 1):
        for i in range(substeps):
            place = max(k + (i + 1.0) / substeps - servo.delay / dt, 0.0)
            left = min(int(place), n - 2)
            wanted = reference[left] + (place - left) * (reference[left + 1] - reference[left])
            asked += keep * (wanted - asked)
            loaded = load[k] + (i + 1.0) / substeps * (load[k + 1] - load[k])
            rate = position_servo.next_rate(asked - q, rate, loaded, servo, h)
            q += h * rate
            y = position_servo.play(y, q, servo.gap)
        if (k + 1) % every == 0:
            out[(k + 1) // every] = (1.0 + servo.scale_error) * y + servo.zero
