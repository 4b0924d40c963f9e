"""Your own closed chain: a four-bar, given by bodies and a closure, identified from the torque of its crank.

python -m gapscope.analysis.examples.own_closed_chain FOLDER
"""

import sys
from pathlib import Path

import numpy as np

from ...models.closure import Closure
from ...models.parallel.chain import Chain, planar
from ..files import output_folder
from ..identification import machine, report, study

CRANK, COUPLER, ROCKER, BASE = 0.10, 0.30, 0.25, 0.30  # lengths [m]


def four_bar() -> Chain:
    """A tree of links, cut where coupler and rocker meet; the closure holds them together."""
    joint = Closure(
        type="ball", body_a="coupler", body_b="rocker", p_a=(COUPLER, 0, 0), p_b=(ROCKER, 0, 0)
    )
    return Chain(
        name="four_bar",
        links=(  # name, parent, joint, its place in the parent's frame, mass, centre, inertia
            planar("crank", "world", "revolute", (0.0, 0.0), 1.0, 0.04, 2e-3),
            planar("coupler", "crank", "revolute", (CRANK, 0.0), 0.8, 0.15, 8e-3),
            planar("rocker", "world", "revolute", (BASE, 0.0), 0.9, 0.12, 6e-3),
        ),
        closures=(joint,),
        driven=("crank",),
        gravity=(0.0, -9.81, 0.0),
        home=(1.0, -0.4, 1.4),  # near a closed posture: its loop is closed from there
    )


def main(folder: Path) -> study.Study:
    """Excite, measure and identify a four-bar whose parameters are up to 20 % off those drawn."""
    one = np.ones(1)
    own = machine.of_chain(
        four_bar(), title="four-bar", unit="rad", start=one, lower=0.2 * one, upper=2.6 * one,
        speed=8.0 * one, acceleration=150.0 * one, frequency=1.0, harmonics=4, budget=60,
        period=0.01, cutoff=15.0, resolution=1e-5, noise=0.02,
        coulomb=0.3 * one, viscous=0.1 * one,
    )  # fmt: skip
    found = study.run(own, methods=("evolution",), budget=own.budget, seed=0, repeats=0)
    report.summarise(found)
    report.write(found, output_folder(folder))
    return found


if __name__ == "__main__":
    main(Path(sys.argv[1]))
