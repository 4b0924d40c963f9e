r"""Results printed for the C-drive benchmark: Friedlaender 2015, Tables 5-4, 5-7, 5-8 and 5-9.

Units as printed: torques N m, translation errors mm, rotation errors rad, all to four decimals, so
half a unit of print is 5e-5. ``tau_rms_Nm`` is the mean of both motors' RMS, ``tau_max_Nm`` the larger
of both motors' maxima; endpoint errors are signed means over cycles. The simulation was run at 2 Hz only.

Table 5-8 is inconsistent, in simulation and in experiment, and should not be fitted:

1. maxima below the RMS of Table 5-4, of the same signal over the same tests: ``e_theta`` of PD in
   rotation (simulation 0.0233 < 0.0283, experiment 0.0156 < 0.0249) and in helical motion
   (simulation 0.0130 < 0.0141);
2. ``e_u`` in pure rotation, whose simulated RMS is 0.0000, has the maximum 0.1972 under all three
   controllers, and ``e_theta`` in pure translation 0.0017: no controller acts on either;
3. the same for the simulated endpoint error ``e_u`` = 0.0077 in pure rotation (Table 5-7);
4. section 5.1.4 reads the largest rotation error as 0.0121 rad and the largest endpoint rotation as
   0.0007 rad; the tables themselves hold 0.0156 and 0.0009.
"""

from collections.abc import Mapping
from dataclasses import dataclass

MOTIONS = ("translation", "rotation", "helical")
CONTROLLERS = ("pd", "ct", "ts")
TAU_RMS, E_U_RMS, E_THETA_RMS = "tau_rms_Nm", "e_u_rms_mm", "e_theta_rms_rad"
TAU_MAX, E_U_MAX, E_THETA_MAX = "tau_max_Nm", "e_u_max_mm", "e_theta_max_rad"
E_U_END, E_THETA_END = "e_u_end_mm", "e_theta_end_rad"
METRICS = (TAU_RMS, E_U_RMS, E_THETA_RMS, E_U_END, E_THETA_END, TAU_MAX, E_U_MAX, E_THETA_MAX)
HALF_PRINT = 5e-5  # half a unit of the last printed decimal, all tables

Key = tuple[str, str, str]  # (controller, motion, metric)
_Table = Mapping[tuple[str, str], tuple[float, ...]]


@dataclass(frozen=True, kw_only=True)
class PrintedRow:
    """One number of the tables, as simulated and as measured; None where it is not printed."""

    controller: str  # one of CONTROLLERS
    motion: str  # one of MOTIONS
    rate_Hz: float  # cycles per second
    metric: str  # one of METRICS, with its unit
    thesis_sim: float | None
    thesis_exp: float | None

    @property
    def key(self) -> Key:
        """What ``benchmark_metrics`` calls this number."""
        return self.controller, self.motion, self.metric


# Per motion and metric: experiment PD, CT, TS, then simulation PD, CT, TS.
_RMS_2_HZ = {
    ("translation", TAU_RMS): (1.4354, 1.3434, 1.3148, 1.4760, 1.4693, 1.4760),
    ("translation", E_U_RMS): (0.3057, 0.3548, 0.2751, 0.3200, 0.1811, 0.3200),
    ("translation", E_THETA_RMS): (0.0037, 0.0009, 0.0009, 0.0000, 0.0000, 0.0000),
    ("rotation", TAU_RMS): (1.0997, 1.0391, 1.0476, 1.2480, 1.1471, 1.1810),
    ("rotation", E_U_RMS): (0.0037, 0.0059, 0.0043, 0.0000, 0.0000, 0.0000),
    ("rotation", E_THETA_RMS): (0.0249, 0.0054, 0.0092, 0.0283, 0.0012, 0.0111),
    ("helical", TAU_RMS): (0.8024, 0.7861, 0.8030, 0.8400, 0.8139, 0.8256),
    ("helical", E_U_RMS): (0.1574, 0.1730, 0.1535, 0.1616, 0.0936, 0.1631),
    ("helical", E_THETA_RMS): (0.0119, 0.0023, 0.0044, 0.0141, 0.0003, 0.0053),
}
_ENDPOINTS_2_HZ = {
    ("translation", E_U_END): (0.0055, 0.0309, 0.0094, 0.0053, 0.0020, 0.0053),
    ("translation", E_THETA_END): (-0.0006, 0.0003, 0.0001, 0.0000, 0.0000, 0.0000),
    ("rotation", E_U_END): (0.0065, 0.0102, 0.0065, 0.0077, 0.0077, 0.0077),
    ("rotation", E_THETA_END): (-0.0009, 0.0000, -0.0006, -0.0018, 0.0002, -0.0001),
    ("helical", E_U_END): (0.0114, 0.0151, 0.0130, 0.0069, 0.0053, 0.0069),
    ("helical", E_THETA_END): (-0.0007, -0.0001, -0.0007, -0.0013, -0.0001, -0.0003),
}
_MAXIMA_2_HZ = {
    ("translation", TAU_MAX): (3.4247, 3.2753, 2.9411, 2.8647, 2.8506, 2.8647),
    ("translation", E_U_MAX): (0.6625, 0.6168, 0.5425, 0.5650, 0.4487, 0.5650),
    ("translation", E_THETA_MAX): (0.0123, 0.0034, 0.0032, 0.0017, 0.0017, 0.0017),
    ("rotation", TAU_MAX): (2.6163, 2.3847, 2.3260, 2.3623, 2.3233, 2.3594),
    ("rotation", E_U_MAX): (0.3773, 0.2053, 0.2029, 0.1972, 0.1972, 0.1972),
    ("rotation", E_THETA_MAX): (0.0156, 0.0077, 0.0110, 0.0233, 0.0049, 0.0118),
    ("helical", TAU_MAX): (2.2811, 2.3241, 2.4782, 2.3586, 2.3834, 2.3980),
    ("helical", E_U_MAX): (0.3033, 0.3077, 0.3840, 0.3718, 0.3138, 0.3717),
    ("helical", E_THETA_MAX): (0.0121, 0.0076, 0.0069, 0.0130, 0.0038, 0.0072),
}
# Experiment only: PD, CT, TS.
_RMS_1_HZ = {
    ("translation", TAU_RMS): (0.5084, 0.4978, 0.5052),
    ("translation", E_U_RMS): (0.1127, 0.0479, 0.1040),
    ("translation", E_THETA_RMS): (0.0007, 0.0006, 0.0005),
    ("rotation", TAU_RMS): (0.2737, 0.2750, 0.2838),
    ("rotation", E_U_RMS): (0.0031, 0.0068, 0.0034),
    ("rotation", E_THETA_RMS): (0.0067, 0.0013, 0.0024),
    ("helical", TAU_RMS): (0.3520, 0.3757, 0.3822),
    ("helical", E_U_RMS): (0.0761, 0.0605, 0.0740),
    ("helical", E_THETA_RMS): (0.0030, 0.0006, 0.0011),
}


def rms_rows(rate_Hz: float) -> tuple[PrintedRow, ...]:
    """Tables 5-4 (2 Hz) and 5-9 (1 Hz, experiment only); ValueError for any other rate."""
    tables: dict[float, _Table] = {2.0: _RMS_2_HZ, 1.0: _RMS_1_HZ}
    if rate_Hz not in tables:
        raise ValueError(f"rate is {rate_Hz} Hz; the thesis prints RMS values at 1 Hz and 2 Hz")
    return _rows(rate_Hz, tables[rate_Hz])


def endpoint_rows() -> tuple[PrintedRow, ...]:
    """Table 5-7: mean signed errors at cycle endpoints, 2 Hz."""
    return _rows(2.0, _ENDPOINTS_2_HZ)


def maximum_rows() -> tuple[PrintedRow, ...]:
    """Table 5-8: mean of the maxima over each cycle, 2 Hz; see the contradictions above."""
    return _rows(2.0, _MAXIMA_2_HZ)


def all_rows() -> tuple[PrintedRow, ...]:
    """Tables 5-4, 5-7, 5-8 and 5-9, in this order."""
    return (*rms_rows(2.0), *endpoint_rows(), *maximum_rows(), *rms_rows(1.0))


def _rows(rate_Hz: float, table: _Table) -> tuple[PrintedRow, ...]:
    return tuple(
        PrintedRow(
            controller=controller,
            motion=motion,
            rate_Hz=rate_Hz,
            metric=metric,
            thesis_sim=values[3 + i] if len(values) == 6 else None,
            thesis_exp=values[i],
        )
        for (motion, metric), values in table.items()
        for i, controller in enumerate(CONTROLLERS)
    )
