r"""Joint limits of the PepperMill-Carrier (Friedlaender 2015, eqs. 2.18-2.25), derived.

Both limits of the elevation :math:`\alpha` of a proximal link are taken where they bind first, with
the limb fully reached out, :math:`h = d^{max}`:

1. top, singular       distal link horizontal: :math:`r\cos\alpha + l = h` (2.22)
2. top, safe           distal link at slope :math:`-\delta_1`: :math:`r\cos\alpha + l\cos\delta_1 = h` (2.23)
3. bottom, singular    limb stretched, :math:`\beta = \alpha`: :math:`(r + l)\cos\alpha = h` (2.24)
4. bottom, safe        :math:`\beta = \alpha - \delta_2`:
   :math:`r\cos\alpha + l\cos(\alpha - \delta_2) = h` (2.25)

The thesis says :math:`\lambda_1 = \pi` before (2.24); that limb would be folded, with reach
:math:`(r - l)\cos\alpha = 0`. The stretched limb has :math:`\lambda_1 = 0`.
"""

from dataclasses import dataclass

import numpy as np

from .geometry import Geometry


@dataclass(frozen=True, kw_only=True)
class ElevationLimits:
    r"""Elevations of the proximal links [rad]: :math:`\theta_1 = \alpha`, :math:`\theta_2 = \pi/2 - \alpha`."""

    singular_min: float  # (2.24), -0.825 for the prototype
    safe_min: float  # (2.25b), -0.530
    safe_max: float  # (2.23), 1.058
    singular_max: float  # (2.22), 1.21


def elevation_limits(geometry: Geometry) -> ElevationLimits:
    """Limits (1)-(4); ValueError if the limbs cannot reach out to ``carriage_max`` or nothing is safe."""
    proximal, distal, reach = geometry.proximal, geometry.distal, geometry.carriage_max
    slope, fold = geometry.distal_margin, geometry.fold_margin
    # (4) as stretched * cos(alpha - lean) = h
    along, aside = proximal + distal * np.cos(fold), distal * np.sin(fold)
    stretched, lean = np.hypot(along, aside), np.arctan2(aside, along)
    bounds = ElevationLimits(
        singular_min=-_arccos(reach / (proximal + distal), geometry),
        safe_min=float(lean) - _arccos(reach / stretched, geometry),
        safe_max=_arccos((reach - distal * np.cos(slope)) / proximal, geometry),
        singular_max=_arccos((reach - distal) / proximal, geometry),
    )
    if bounds.safe_min >= bounds.safe_max:
        raise ValueError(
            f"PMC geometry: the margins distal_margin = {slope} and fold_margin = {fold} rad leave no "
            "elevation; expected smaller margins"
        )
    return bounds


def theta_bounds(geometry: Geometry) -> tuple[tuple[float, float], tuple[float, float]]:
    """Safe bounds of theta_1 and theta_2 [rad], eq. (2.19): ((min, max), (min, max))."""
    safe = elevation_limits(geometry)
    return (safe.safe_min, safe.safe_max), (np.pi / 2 - safe.safe_max, np.pi / 2 - safe.safe_min)


def _arccos(cosine: float, geometry: Geometry) -> float:
    if not -1.0 < cosine < 1.0:
        raise ValueError(
            f"PMC geometry: links of {geometry.proximal} m and {geometry.distal} m have no limit "
            f"posture at the reach carriage_max = {geometry.carriage_max} m; expected a reach "
            "that crosses both singularities, |l - r| < carriage_max < l + r with margins"
        )
    return float(np.arccos(cosine))
