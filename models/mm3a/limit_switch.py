"""The audio limit switch of section 4.1.2: the motor sounds different when it drives against a stop.

A loop records the sound of every five steps and looks for a peak in its spectrum, so a stop is noticed at the
end of the loop it is in: a count is right to five steps, never too small. That is 0.02 % to 0.06 % of the 9 000
to 28 000 steps across joint 3 at the steps of Fig. 4.13, and 0.01 % for joint 2; the 0.005 % printed there would
need 100 000 steps. Not modelled: the daily tuning of the peak's frequency and threshold.
"""

LOOP = 5  # steps per recording


def heard_steps(steps_to_stop: int, loop: int = LOOP) -> int:
    """Steps counted when the first step against the stop is number ``steps_to_stop``."""
    if steps_to_stop < 0 or loop < 1:
        raise ValueError(
            f"limit switch: {steps_to_stop} steps, loop of {loop}; expected steps >= 0, loop >= 1"
        )
    return loop * -(-steps_to_stop // loop)
