"""Compiled loops over ``servo_pendulum.py``: stabilised prediction and closed-loop simulation.

Samples may come at uneven times. Between them the firmware, whose loop is faster than the log, holds
the reference it was last sent and follows the position: the voltage runs from what is logged at a
sample to what the law makes of the next position, and jumps there with the reference.
"""

from typing import Any

from . import compilation, drive_kernels, friction, servo_pendulum

compilation.register_laws(friction, servo_pendulum)


@compilation.kernel
def predict(
    t: Any,
    position: Any,
    voltage: Any,
    arriving: Any,
    connected: Any,
    servo: Any,
    substeps: int,
    bandwidth: float,
    residual: Any,
) -> None:
    """Prediction errors ``residual`` (samples,) [rad] of a logged run; all arrays (samples,).

    Driven by the voltage [V], which goes from ``voltage[k]`` to ``arriving[k]`` between samples k and
    k + 1, the model says where the encoder will be at the next sample and is then corrected with a
    double pole at ``bandwidth`` [rad/s]. Starts at rest.
    """
    q, v, lag = position[0], 0.0, voltage[0]
    seen = 0
    for k in range(position.size):
        error = position[k] - q
        residual[k] = error
        if k == position.size - 1:
            return
        h = t[k + 1] - t[k]
        on_position, on_rate = drive_kernels.correction_gains(bandwidth, h)
        q += on_position * error
        v += on_rate * error
        part = h / substeps
        for i in range(substeps):
            when = t[k] + (i + 0.5) * part - servo.delay
            while seen > 0 and t[seen] > when:
                seen -= 1
            while seen < t.size - 2 and t[seen + 1] <= when:
                seen += 1
            share = min(max((when - t[seen]) / (t[seen + 1] - t[seen]), 0.0), 1.0)
            wanted = voltage[seen] + share * (arriving[seen] - voltage[seen])
            lag = servo_pendulum.lagged(lag, wanted, servo.lag, part)
            q, v = servo_pendulum.step(q, v, lag, connected[k], part, servo)


@compilation.kernel
def simulate(
    t: Any,
    reference: Any,
    supply: float,
    gain: float,
    connected: Any,
    servo: Any,
    substeps: int,
    position: Any,
    voltage: Any,
) -> None:
    """Closed loop from rest at ``position[0]``: writes position [rad] and voltage [V], (samples,).

    The firmware runs once a substep on the encoder's reading and the last reference it was sent;
    ``servo.delay`` is taken as whole substeps.
    """
    q, v, lag = position[0], 0.0, 0.0
    for k in range(t.size):
        wanted = supply * servo_pendulum.duty(reference[k] - servo_pendulum.counted(q), gain)
        voltage[k] = connected[k] * wanted
        position[k] = servo_pendulum.counted(q)
        if k == t.size - 1:
            return
        h = t[k + 1] - t[k]
        q, v, lag = advance(q, v, lag, reference[k], supply, gain, connected[k], servo, h, substeps)


@compilation.kernel
def advance(
    q: float, v: float, lag: float, reference: float, supply: float, gain: float, connected: float,
    servo: Any, h: float, substeps: int,
) -> Any:  # fmt: skip
    """Position, rate and lagged voltage after ``h`` seconds of the firmware's loop on one reference [rad]."""
    part = h / substeps
    for _ in range(substeps):
        wanted = supply * servo_pendulum.duty(reference - servo_pendulum.counted(q), gain)
        lag = servo_pendulum.lagged(lag, wanted, servo.lag, part)
        q, v = servo_pendulum.step(q, v, lag, connected, part, servo)
    return q, v, lag
