"""Controller comparison: which of three controllers follows the C-drive's helical motion best?

python -m gapscope.analysis.examples.controllers FOLDER
"""

import sys
from pathlib import Path

import numpy as np

from ...models import c_drive
from ...models.benchmark import Conditions, benchmark_run, sampled_controllers
from ...models.c_drive import CDriveParameters
from ..figures import BLUE, GREEN, VERMILION, plt
from ..files import output_folder


def main(folder: Path) -> dict[str, tuple[float, float]]:
    """Rms errors of the collar, (u [m], theta [rad]) by controller; draws ``controllers.png``."""
    plant, settings = c_drive.drive(CDriveParameters()), sampled_controllers(CDriveParameters())
    figure, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(8, 5), layout="constrained")
    errors = {}
    looks = ((BLUE, 3.0), (VERMILION, 1.5), (GREEN, 1.2))  # two may lie on each other
    for (name, controller), (colour, width) in zip(settings.items(), looks):
        run = benchmark_run(plant, controller, "helical", Conditions(rate=2.0))
        u, theta = np.sqrt(np.mean(run.error**2, axis=0))
        errors[name] = (float(u), float(theta))
        top.plot(run.time, 1e3 * run.error[:, 0], color=colour, lw=width, label=name.upper())
        bottom.plot(run.time, 1e3 * run.error[:, 1], color=colour, lw=width)
    top.set_ylabel("translation error [mm]")
    bottom.set_ylabel("rotation error [mrad]")
    bottom.set_xlabel("time [s]")
    best = min(errors, key=lambda name: errors[name][0])
    top.set_title(
        f"Helical motion at 2 Hz: {best.upper()} has the least translation error", loc="left"
    )
    figure.legend(loc="outside lower center", frameon=False, ncols=3)
    figure.savefig(output_folder(folder) / "controllers.png", dpi=120)
    plt.close(figure)
    return errors


if __name__ == "__main__":
    for name, (u, theta) in main(Path(sys.argv[1])).items():
        sys.stdout.write(f"{name}: {1e3 * u:.3f} mm, {1e3 * theta:.2f} mrad\n")
