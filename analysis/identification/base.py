r"""Base parameters of a rank-deficient regressor: what of the parameters the forces show (Roldan, 5.2.4).

With the columns of :math:`V_2` spanning the null space of W and a permutation that makes the lower block
:math:`V_{22}` regular, :math:`\Phi_{base} = (I\ B) P^T \Phi,\ B = -V_{21} V_{22}^{-1}` (5.29)-(5.31). The search for
:math:`V_{22}` starts at the last parameter, so that early names are kept. QR with pivoting keeps others, and spans
the same space.
"""

from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# A singular value of a scaled regressor this much below the largest is rounding.
NULL = 1e-9


class Base(NamedTuple):
    """Base parameters are ``combination`` @ parameters; their regressor is W[:, kept]."""

    kept: tuple[int, ...]
    combination: Floats  # (base, parameters), identity on the kept columns
    singular: Floats  # of the regressor with columns of unit length, falling

    @property
    def gap(self) -> float:
        """Smallest singular value that counts over the largest that does not (inf at full rank)."""
        rank = len(self.kept)
        if rank == self.singular.size:
            return float("inf")
        return float(self.singular[rank - 1] / max(self.singular[rank], 1e-300))


def by_svd(regressor: Floats) -> Base:
    """Base parameters by the permutation of 5.2.4; ``regressor`` (rows, parameters) at random states."""
    scaled, scale = _unit_columns(regressor)
    _, singular, right = np.linalg.svd(scaled, full_matrices=True)
    rank = _rank(singular)
    null = right[rank:].T
    dropped: list[int] = []
    for row in range(null.shape[0] - 1, -1, -1):
        if len(dropped) == null.shape[1]:
            break
        trial = null[[row, *dropped]]
        if np.linalg.svd(trial, compute_uv=False)[-1] > 1e-7:
            dropped.insert(0, row)
    kept = [k for k in range(null.shape[0]) if k not in dropped]
    share = -null[kept] @ np.linalg.inv(null[dropped]) if dropped else np.zeros((len(kept), 0))
    return _base(kept, dropped, share, scale, singular)


def by_qr(regressor: Floats) -> Base:
    """Base parameters by QR with column pivoting: the best conditioned columns are kept."""
    scaled, scale = _unit_columns(regressor)
    singular = np.asarray(np.linalg.svd(scaled, compute_uv=False), dtype=float)
    rank = _rank(singular)
    _, upper, order = scipy.linalg.qr(scaled, mode="economic", pivoting=True)
    share = scipy.linalg.solve_triangular(upper[:rank, :rank], upper[:rank, rank:])
    kept, dropped = list(order[:rank]), list(order[rank:])
    rows = np.argsort(kept)
    return _base([kept[i] for i in rows], dropped, share[rows], scale, singular)


def words(base: Base, names: tuple[str, ...]) -> list[str]:
    """Base parameters as sums of named parameters; shares below 1e-9 of the largest are left out."""
    lines = []
    for row in base.combination:
        terms = [
            f"{value:+.5g} {name}" if abs(value - 1.0) > 1e-9 else f"+ {name}"
            for value, name in zip(row, names)
            if abs(value) > 1e-9 * np.abs(row).max()
        ]
        lines.append(" ".join(terms).removeprefix("+ "))
    return lines


def condition(regressor: Floats) -> Floats:
    """Condition number (...) of regressors (..., rows, columns); inf where they are not finite."""
    gram = np.einsum("...ri,...rj->...ij", regressor, regressor, optimize=True)
    usable = np.isfinite(gram).all(axis=(-1, -2))
    values = np.linalg.eigvalsh(np.where(usable[..., None, None], gram, np.eye(gram.shape[-1])))
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.sqrt(values[..., -1] / np.maximum(values[..., 0], 0.0))
    return np.asarray(np.where(usable, found, np.inf))


def _unit_columns(regressor: Floats) -> tuple[Floats, Floats]:
    scale = np.linalg.norm(regressor, axis=0)
    seen = scale > 1e-12 * scale.max()  # what is less is rounding, not motion
    scale = np.where(seen, scale, 1.0)
    return np.where(seen, regressor / scale, 0.0), scale


def _rank(singular: Floats) -> int:
    return int(np.sum(singular > NULL * singular[0]))


def _base(
    kept: list[int], dropped: list[int], share: Floats, scale: Floats, singular: Floats
) -> Base:
    """``share`` (kept, dropped) is what of each kept, scaled column a dropped one holds."""
    combination = np.zeros((len(kept), scale.size))
    combination[np.arange(len(kept)), kept] = 1.0
    combination[:, dropped] = share * scale[dropped] / scale[kept][:, None]
    # Rounding, a thousand times below what is kept as non-zero anywhere else.
    combination[np.abs(combination) < 1e-10 * np.abs(combination).max()] = 0.0
    return Base(tuple(int(k) for k in kept), combination, singular)
