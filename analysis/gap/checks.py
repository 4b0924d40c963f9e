"""Checks that every reader of a log set shares; each ends in one ``InputError``."""

from collections.abc import Collection, Iterable
from difflib import get_close_matches
from typing import Any

import numpy as np

from ..errors import InputError

SHOWN = 60  # characters of a wrong value that are worth reading


def refuse_unknown(where: object, keys: Iterable[Any], known: Collection[str]) -> None:
    """Refuse the first key that is not known, with the known one that it resembles."""
    unknown = sorted(str(key) for key in keys if key not in known)
    if not unknown:
        return
    by_lower = {name.lower(): name for name in known}
    near = get_close_matches(unknown[0].lower(), by_lower, n=1)
    raise InputError(
        where,
        f"unknown key {shown(unknown[0])}",
        f"one of {', '.join(sorted(known))}",
        f"Did you mean {by_lower[near[0]]!r}?" if near else "",
    )


def finite_number(
    where: object, value: Any, *, above: float | None = None, least: float | None = None
) -> float:
    """``value`` as a finite float, greater than ``above`` or at least ``least``; True is no number."""
    wanted = "a finite number"
    if above is not None:
        wanted = "a positive number" if above == 0.0 else f"a number above {above:g}"
    if least is not None:
        wanted = f"a number of at least {least:g}"
    number = as_float(value)
    low = (above is not None and number <= above) or (least is not None and number < least)
    if not abs(number) < np.inf or low:
        raise InputError(where, shown(value), wanted)
    return number


def as_float(value: Any) -> float:
    """``value`` as a float, NaN for what is no number or too large for one."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return float("nan")
    try:
        return float(value)
    except OverflowError:  # an integer of hundreds of digits
        return float("nan")


def shown(value: Any) -> str:
    """A value as it is quoted in a message, cut where it is long."""
    try:
        text = "nothing" if value is None else repr(value)
    except ValueError:  # an integer of thousands of digits
        text = "a number of thousands of digits"
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}..."
