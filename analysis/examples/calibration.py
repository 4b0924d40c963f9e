"""Calibration: step sizes of the MM3A micromanipulator from counted steps, with their intervals.

python -m gapscope.analysis.examples.calibration FOLDER
"""

import sys
from pathlib import Path

from ..files import output_folder
from ..mm3a import calibration, experiments
from ..mm3a.calibration import Calibration


def main(folder: Path) -> Calibration:
    """Two days of simulated measurements, calibrated; writes ``calibration.json`` and ``calibration.png``."""
    runs = experiments.full_experiment("empirical", days=2, repeats=2, seed=0)
    result = calibration.calibrate(runs)
    calibration.write(result, output_folder(folder))
    return result


if __name__ == "__main__":
    from ..mm3a.terminal import print_calibration

    print_calibration(main(Path(sys.argv[1])))
