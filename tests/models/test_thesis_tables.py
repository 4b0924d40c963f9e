"""The typed tables against the percentages the thesis prints of them (Tables 5-5, 5-6, 5-9)."""

import pytest

from gapscope.models import thesis_tables as T

HALF_PERCENT_PRINT = 0.005


def column(rate, source):
    return {row.key: getattr(row, source) for row in T.rms_rows(rate)}


def percent_range(new, old):
    """Least and greatest percentage that values rounded to four decimals allow."""
    h = T.HALF_PRINT
    ends = [100.0 * ((new + a) / (old + b) - 1.0) for a in (-h, h) for b in (-h, h)]
    return min(ends) - HALF_PERCENT_PRINT, max(ends) + HALF_PERCENT_PRINT


# Table 5-5, PD, CT, TS.
TABLE_5_5 = {
    ("translation", T.TAU_RMS): (2.83, 9.37, 12.27),
    ("translation", T.E_U_RMS): (4.68, -48.96, 16.32),
    ("rotation", T.TAU_RMS): (13.49, 10.39, 12.74),
    ("rotation", T.E_THETA_RMS): (13.61, -78.48, 20.89),
    ("helical", T.TAU_RMS): (4.69, 3.54, 2.82),
    ("helical", T.E_U_RMS): (2.64, -45.93, 6.27),
    ("helical", T.E_THETA_RMS): (18.89, -86.16, 19.65),
}
# Table 5-6: CT and TS against PD, experiment then simulation.
TABLE_5_6 = {
    ("translation", T.TAU_RMS): (-6.41, -8.40, -0.46, 0.00),
    ("translation", T.E_U_RMS): (16.07, -10.00, -43.41, 0.00),
    ("translation", T.E_THETA_RMS): (-74.92, -75.87, None, None),
    ("rotation", T.TAU_RMS): (-5.51, -4.74, -8.08, -5.37),
    ("rotation", T.E_U_RMS): (60.94, 18.62, None, None),
    ("rotation", T.E_THETA_RMS): (-78.24, -62.97, -95.88, -60.60),
    ("helical", T.TAU_RMS): (-2.03, 0.07, -3.11, -1.72),
    ("helical", T.E_U_RMS): (9.92, -2.49, -42.09, 0.96),
    ("helical", T.E_THETA_RMS): (-80.88, -62.77, -97.77, -62.53),
}
# Table 5-9, percentages at 1 Hz: CT, TS against PD, experiment.
TABLE_5_9 = {
    ("translation", T.TAU_RMS): (-2.09, -0.63),
    ("translation", T.E_U_RMS): (-57.50, -7.76),
    ("translation", T.E_THETA_RMS): (-14.19, -33.10),
    ("rotation", T.TAU_RMS): (0.48, 3.71),
    ("rotation", T.E_U_RMS): (117.24, 7.19),
    ("rotation", T.E_THETA_RMS): (-81.01, -63.60),
    ("helical", T.TAU_RMS): (6.73, 8.56),
    ("helical", T.E_U_RMS): (-20.51, -2.72),
    ("helical", T.E_THETA_RMS): (-80.44, -61.74),
}


def outside(comparisons):
    misfits = []
    for label, printed, new, old in comparisons:
        low, high = percent_range(new, old)
        if not low <= printed <= high:
            misfits.append(label)
    return misfits


def test_table_5_5_follows_from_table_5_4():
    sim, exp = column(2.0, "thesis_sim"), column(2.0, "thesis_exp")
    comparisons = [
        ((c, *cell), printed, sim[c, *cell], exp[c, *cell])
        for cell, row in TABLE_5_5.items()
        for c, printed in zip(T.CONTROLLERS, row)
    ]
    assert len(comparisons) == 21
    assert outside(comparisons) == []


def test_table_5_6_follows_from_table_5_4():
    comparisons = []
    for cell, row in TABLE_5_6.items():
        for source, pair in (("thesis_exp", row[:2]), ("thesis_sim", row[2:])):
            values = column(2.0, source)
            comparisons += [
                ((source, c, *cell), printed, values[c, *cell], values["pd", *cell])
                for c, printed in zip(("ct", "ts"), pair)
                if printed is not None
            ]
    assert len(comparisons) == 32
    assert outside(comparisons) == []


def test_percentages_of_table_5_9_follow_from_its_values():
    values = column(1.0, "thesis_exp")
    comparisons = [
        ((c, *cell), printed, values[c, *cell], values["pd", *cell])
        for cell, row in TABLE_5_9.items()
        for c, printed in zip(("ct", "ts"), row)
    ]
    assert outside(comparisons) == []


def test_maxima_below_the_rms_of_the_same_signal_are_the_ones_listed():
    below = set()
    rms = {row.key: row for row in T.rms_rows(2.0)}
    for row in T.maximum_rows():
        partner = rms[row.controller, row.motion, row.metric.replace("_max_", "_rms_")]
        for source in ("thesis_sim", "thesis_exp"):
            if getattr(row, source) < getattr(partner, source):
                below.add((source, *row.key))
    assert below == {
        ("thesis_sim", "pd", "rotation", T.E_THETA_MAX),
        ("thesis_sim", "pd", "helical", T.E_THETA_MAX),
        ("thesis_exp", "pd", "rotation", T.E_THETA_MAX),
    }


def test_every_row_is_there_once():
    rows = T.all_rows()
    assert len({(row.key, row.rate_Hz) for row in rows}) == len(rows) == 27 + 18 + 27 + 27
    assert {row.metric for row in rows} == set(T.METRICS)


def test_unprinted_rate_is_refused():
    with pytest.raises(ValueError, match="1 Hz and 2 Hz"):
        T.rms_rows(3.0)
