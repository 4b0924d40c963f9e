"""The C-drive's own gap: diagnosed from the printed RMS values of the experiment, without time series.

``gapscope diagnose thesis-c-drive``. Source: Friedlaender 2015, Tables 5-4 (2 Hz, fitted) and 5-9
(1 Hz, held out).
"""
