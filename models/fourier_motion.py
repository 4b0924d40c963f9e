"""Periodic motions as finite Fourier series that start and end every cycle at rest.

Shaft j moves as q_j(t) = sum_k c_jk (cos(k w t) - 1) + s_jk sin(k w t), k = 1..K, w = 2 pi/period,
with sum_k k s_jk = 0 and sum_k k^2 c_jk = 0: position, speed and acceleration are zero at the start
and the end of a cycle (Swevers et al. 1997, IEEE Trans. Robotics and Automation 13, 730, who leave
the ends free). Angles in rad (or m for a linear shaft), times in s.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import ArrayLike, NDArray

from .yaml_mapping import read_yaml_mapping

Array = NDArray[np.float64]

AT_REST = 1e-6  # end speed and acceleration over the largest of the harmonics', of rounded files
KEYS = ("name", "period", "cycles", "cosine", "sine")


@dataclass(frozen=True, kw_only=True)
class FourierMotion:
    """One cycle per period and shaft, repeated without pause.

    Raises ValueError for a period or number of cycles that is not positive, for coefficients that
    are not two equal tables (shafts, harmonics) of finite numbers, and for a motion that does not
    start at rest and without acceleration.
    """

    name: str
    period: float  # of one cycle [s]
    cycles: int
    cosine: tuple[tuple[float, ...], ...]  # c_jk (shafts, harmonics) [position unit]
    sine: tuple[tuple[float, ...], ...]  # s_jk (shafts, harmonics) [position unit]

    def __post_init__(self) -> None:
        if not 0.0 < self.period < np.inf:
            raise ValueError(f"period is {self.period}; expected a positive number of seconds")
        if self.cycles < 1:
            raise ValueError(f"cycles is {self.cycles}; expected 1 or more")
        try:
            c, s = np.array(self.cosine, dtype=float), np.array(self.sine, dtype=float)
        except (ValueError, TypeError):
            raise ValueError("cosine and sine are ragged; expected tables of numbers") from None
        if c.ndim != 2 or c.shape != s.shape or c.size == 0:
            raise ValueError(
                f"cosine and sine have shapes {c.shape} and {s.shape}; expected two equal tables "
                "(shafts, harmonics)"
            )
        if not (np.all(np.isfinite(c)) and np.all(np.isfinite(s))):
            raise ValueError("cosine or sine holds a value that is not finite; expected numbers")
        k = np.arange(1, c.shape[1] + 1)
        for word, terms in (("speed", k * s), ("acceleration", k**2 * c)):
            if np.any(np.abs(terms.sum(axis=1)) > AT_REST * max(np.max(np.abs(terms)), 1e-12)):
                raise ValueError(
                    f"the motion starts with a {word}; expected sum of k sine_k = 0 and sum of "
                    "k^2 cosine_k = 0 for every shaft"
                )

    @property
    def rate(self) -> float:
        """Cycles per second [Hz]."""
        return 1.0 / self.period

    @property
    def shafts(self) -> int:
        """Number of shafts."""
        return len(self.cosine)

    def sample(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """Positions, rates and accelerations at times ``t`` [s]: arrays (..., shafts)."""
        return series(np.array(self.cosine), np.array(self.sine), self.period, t)

    def times(self, dt: float) -> Array:
        """Sample times of all cycles [s]."""
        return _floats(dt * np.arange(round(self.cycles * self.period / dt)))

    def save(self, path: str | Path) -> None:
        """Write the motion as YAML."""
        Path(path).write_text(self.text(), encoding="utf-8")

    def text(self) -> str:
        """The motion as YAML; coefficients are written in full, so that the ends stay at rest."""
        document = {
            "name": self.name,
            "period": float(self.period),
            "cycles": int(self.cycles),
            "cosine": [[float(v) for v in row] for row in self.cosine],
            "sine": [[float(v) for v in row] for row in self.sine],
        }
        return yaml.safe_dump(document, sort_keys=False)


def series(cosine: Array, sine: Array, period: float, t: ArrayLike) -> tuple[Array, Array, Array]:
    """Positions, rates and accelerations (..., shafts) of the sum above at times ``t`` [s], with any ends.

    ``cosine`` and ``sine`` are (shafts, harmonics).
    """
    w = 2.0 * np.pi / period
    k = np.arange(1, cosine.shape[1] + 1)
    phase = np.multiply.outer(np.asarray(t, dtype=float), k * w)
    cos, sin = np.cos(phase), np.sin(phase)
    c, s = cosine.T, sine.T
    kw = (k * w)[:, None]
    rate = cos @ (kw * s) - sin @ (kw * c)
    acceleration = -cos @ (kw**2 * c) - sin @ (kw**2 * s)
    return _floats((cos - 1.0) @ c + sin @ s), _floats(rate), _floats(acceleration)


def load_motion(path: str | Path) -> FourierMotion:
    """The motion of a YAML file; ValueError names the file and the key that cannot be used."""
    document = read_yaml_mapping(path)
    if set(document) != set(KEYS):
        raise ValueError(f"{path}: found {sorted(document)}; expected keys {', '.join(KEYS)}")
    try:
        return FourierMotion(
            name=str(document["name"]),
            period=_number(document, "period"),
            cycles=int(_number(document, "cycles")),
            cosine=_table(document, "cosine"),
            sine=_table(document, "sine"),
        )
    except (ValueError, OverflowError) as error:
        raise ValueError(f"{path}: {error}") from None


def _number(document: Mapping[str, Any], key: str) -> float:
    value = document[key]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{key} is {value!r}; expected a number")
    return float(value)


def _table(document: Mapping[str, Any], key: str) -> tuple[tuple[float, ...], ...]:
    try:
        return tuple(tuple(float(v) for v in row) for row in document[key])
    except (TypeError, ValueError):
        raise ValueError(
            f"{key} is not a list of lists of numbers; expected one per shaft"
        ) from None


def _floats(values: Any) -> Array:
    return np.asarray(values, dtype=np.float64)
