"""Why did resolved acceleration become unstable when k_P^t != k_P^r? (Friedlaender 2015, 4.6.4)

The thesis leaves the cause open. This study answers with eigenvalues of the exact sampled loop
(``models/loop_stability.py``): hold, derivative filter, observer, delay and lag of the torque path.

1. Different gains do not destabilise by themselves. J^-1 K J, M and D have the same eigenvectors, so the
   loop splits into one for translation and one for rotation; the stable gains form a rectangle.
2. The printed gains of computed torque lie in the corner of that rectangle. With the torque filter
   of Appendix A (Pn401, 0.6 ms) and the torque loop of section 4.6.2 (half a sample, 0.5 ms), nothing
   fitted, the largest stable gains are 37600 (translation) and 35200 1/s^2 (rotation) where 35000 is
   printed, and 48 N m/rad for PD where 45 is printed, tuned "just below the limit of stability".
3. So the natural use of a task-space controller, to raise one gain (2.5 times for rotation in Table 5-1),
   leaves the rectangle: inverse dynamics has already multiplied the rotation gain by its inertia.
4. Tried and rejected: gains in the units of Table 5-1 (slow but stable), left-right mismatch (stable
   below the corner, also with unequal gains), soft couplings (equal gains are unstable, too), counts of
   the encoder in the derivative (the Drake loop with 13 bits stays bounded where the eigenvalues
   are stable, also with unequal gains).

Accuracy: the amplifier's torque is its mean over a sample, which moves these limits by about 1 %, and
5 % in the controller's model by 2 %. Not explained: a loop that becomes unstable because one gain is
lowered, and why the TS rotation gain stops at 0.7 of its limit. The thesis does not print the
gains that were tried, nor the latency of its input and output cards.
"""

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from ..models import c_drive, drive
from ..models.c_drive import CDriveParameters
from ..models.c_drive_controllers import PD, ComputedTorque, TaskSpacePD, loop_controller
from ..models.c_drive_state_space import collar_modes
from ..models.drive import Drive
from ..models.loop_stability import Mode, dominant_mode
from .files import write_folder

Settings = PD | TaskSpacePD | ComputedTorque

SAMPLE_TIME = 1e-3  # Table 5-3 [s]
TUNED = ComputedTorque()  # Table 5-1
TASK_SPACE = TaskSpacePD()  # Table 5-1
RATIO = TASK_SPACE.kp_rotation / TASK_SPACE.kp_translation  # of the gains in Table 5-1
WEAK = 0.1  # gain of the other direction while one is searched, as a fraction of the tuned one


@dataclass(frozen=True, kw_only=True)
class TorquePath:
    """What lies between the torque command and the torque, beside the hold."""

    name: str
    delay: float  # [s]
    lag: float  # [s]
    evidence: str


TORQUE_PATHS = (
    TorquePath(name="ideal", delay=0.0, lag=0.0, evidence="assumed in section 4.6.2"),
    TorquePath(
        name="filter",
        delay=0.0,
        lag=0.6e-3,
        evidence="torque reference filter Pn401 = 60 x 0.01 ms, Appendix A",
    ),
    TorquePath(
        name="as printed",
        delay=0.5e-3,
        lag=0.6e-3,
        evidence="Pn401, and a torque loop of half a sample, footnote to section 4.6.2",
    ),
    TorquePath(
        name="one sample",
        delay=1.0e-3,
        lag=0.0,
        evidence="torque written one sample late, usual for a real-time target; not printed",
    ),
)
PRINTED = TORQUE_PATHS[2]


@dataclass(frozen=True, kw_only=True)
class TunedGain:
    """A gain that Table 5-1 reports as the highest stable one, beside the limit of the model."""

    name: str
    unit: str
    printed: float
    limit: float  # largest stable gain, the other settings as printed

    @property
    def share(self) -> float:
        """Printed gain as a fraction of the limit."""
        return self.printed / self.limit


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One setting of the loop and its least damped mode."""

    name: str
    growth: float  # [1/s], negative is stable
    frequency: float  # [Hz]


@dataclass(frozen=True, kw_only=True)
class StabilityMap:
    """Growth rate of the least damped mode over the two gains of resolved acceleration."""

    kp_translation: NDArray[np.float64]  # (n,) [1/s^2]
    kp_rotation: NDArray[np.float64]  # (m,) [1/s^2]
    growth: NDArray[np.float64]  # (m, n) [1/s]


@dataclass(frozen=True, kw_only=True)
class Study:
    """All numbers of the answer."""

    limits: dict[str, list[TunedGain]]  # by torque path
    trials: list[Trial]
    map: StabilityMap


def plant(path: TorquePath = PRINTED, parameters: CDriveParameters | None = None) -> Drive:
    """The C-drive with this torque path."""
    machine = c_drive.drive(parameters or CDriveParameters())
    machine.shaft[:, drive.DELAY] = path.delay
    machine.shaft[:, drive.LAG] = path.lag
    return machine


def elastic_plant(stiffness: float, damping: float, motor_inertia: float) -> Drive:
    """The C-drive with a flexible coupling [N m/rad, N m s/rad] behind each motor [kg m^2].

    Shafts: motors (L, R), screws (L, R). The rest of M is on the screws' side.
    """
    p, own = CDriveParameters(), motor_inertia * np.eye(2)
    inertia = np.block(
        [[own, np.zeros((2, 2))], [np.zeros((2, 2)), c_drive.inertia_matrix(p) - own]]
    )
    elements = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]])
    machine = drive.ideal_drive(inertia, elements, [p.beta, p.beta, 0.5 * p.gamma], p.sign_width)
    machine.shaft[:, drive.DELAY] = PRINTED.delay
    machine.shaft[:, drive.LAG] = PRINTED.lag
    pairs = [[side, side + 2, stiffness, damping, 0.0] for side in range(2)]
    return machine._replace(coupling=np.array(pairs))


def mode(settings: Settings, machine: Drive, model_error: float = 1.0, substeps: int = 1) -> Mode:
    """Least damped mode of the loop; ``model_error`` scales the controller's M and D."""
    model = CDriveParameters().scaled_model(model_error)
    controller = loop_controller(settings, model, SAMPLE_TIME)
    return dominant_mode(machine, controller, SAMPLE_TIME, substeps)


def gains(
    translation: float,
    rotation: float,
    kd_translation: float = TUNED.kd,
    kd_rotation: float = TUNED.kd,
) -> ComputedTorque:
    """Resolved acceleration with these gains [1/s^2, 1/s], the rest as in Table 5-1."""
    return ComputedTorque(
        kp=translation, kd=kd_translation, kp_rotation=rotation, kd_rotation=kd_rotation
    )


def largest_stable(growth: Callable[[float], float], start: float) -> float:
    """Gain at which ``growth`` crosses zero, searched between 0.02 and 50 times ``start``.

    Raises ValueError if the loop is not stable at the lower end and unstable at the upper one.
    """
    low, high = np.log(0.02 * start), np.log(50.0 * start)
    ends = growth(float(np.exp(low))), growth(float(np.exp(high)))
    if not ends[0] < 0.0 < ends[1]:
        raise ValueError(
            f"growth rates are {ends[0]:.3g} and {ends[1]:.3g} 1/s at the ends; expected a loop that "
            "becomes unstable as the gain rises"
        )
    return float(np.exp(brentq(lambda x: growth(float(np.exp(x))), low, high, xtol=1e-6)))


def tuned_gains(path: TorquePath) -> list[TunedGain]:
    """The four gains of Table 5-1 beside the largest stable ones behind this torque path."""
    machine = plant(path)
    pd, ts, kp = PD(), TASK_SPACE, TUNED.kp

    def ts_growth(k: float) -> float:
        return mode(
            TaskSpacePD(kp_translation=WEAK * ts.kp_translation, kp_rotation=k), machine
        ).growth

    return [
        TunedGain(
            name="PD",
            unit="N m/rad",
            printed=pd.kp,
            limit=largest_stable(lambda k: mode(PD(kp=k), machine).growth, pd.kp),
        ),
        TunedGain(
            name="TS rotation",
            unit="N m/rad",
            printed=ts.kp_rotation,
            limit=largest_stable(ts_growth, ts.kp_rotation),
        ),
        TunedGain(
            name="CT translation",
            unit="1/s^2",
            printed=kp,
            limit=largest_stable(lambda k: mode(gains(k, WEAK * kp), machine).growth, kp),
        ),
        TunedGain(
            name="CT rotation",
            unit="1/s^2",
            printed=kp,
            limit=largest_stable(lambda k: mode(gains(WEAK * kp, k), machine).growth, kp),
        ),
    ]


def trials() -> list[Trial]:
    """Settings that test one explanation each, behind the torque path as printed."""
    return [Trial(name=name, growth=m.growth, frequency=m.frequency) for name, m in _trial_modes()]


def _trial_modes() -> Iterator[tuple[str, Mode]]:
    machine, kp, kd = plant(), TUNED.kp, TUNED.kd
    yield "equal gains, 35000 1/s^2", mode(gains(kp, kp), machine)
    yield "rotation gains 2.5 times", mode(gains(kp, RATIO * kp, kd, RATIO * kd), machine)
    yield "rotation kp 2.5 times", mode(gains(kp, RATIO * kp), machine)
    yield (
        "rotation gains 2.5 times, ideal torque path",
        mode(gains(kp, RATIO * kp, kd, RATIO * kd), plant(TORQUE_PATHS[0])),
    )
    yield "translation kp 2.5 times", mode(gains(RATIO * kp, kp), machine)
    yield "rotation kp 10 % up", mode(gains(kp, 1.1 * kp), machine)
    yield "rotation kp 10 % down", mode(gains(kp, 0.9 * kp), machine)
    yield "translation kp 2.5 times down", mode(gains(kp / RATIO, kp), machine)
    yield "rotation kp 2.5 times down", mode(gains(kp, kp / RATIO), machine)
    ts = TASK_SPACE
    yield (
        "gains of the TS column taken as 1/s^2",
        mode(gains(ts.kp_translation, ts.kp_rotation, ts.kd_translation, ts.kd_rotation), machine),
    )
    lower = gains(0.8 * kp, 0.4 * kp)
    uneven = plant()
    uneven.shaft[:, drive.GAIN] = [1.3, 0.7]
    yield "motors 30 % unlike, kp 28000 and 14000", mode(lower, uneven)
    uneven = plant()
    uneven.shaft[:, drive.DELAY] += [0.25e-3, -0.25e-3]
    yield "motors 0.5 ms apart, kp 28000 and 14000", mode(lower, uneven)
    yield "model 5 % too large, equal gains", mode(gains(kp, kp), machine, 1.05)
    yield "model 5 % too small, equal gains", mode(gains(kp, kp), machine, 0.95)
    for stiffness in (100.0, 3000.0):
        elastic = elastic_plant(stiffness, 0.04, 3e-4)
        for name, pair in (("equal", (0.8, 0.8)), ("unequal", (0.8, 0.4))):
            settings = gains(pair[0] * kp, pair[1] * kp)
            label = f"couplings of {stiffness:g} N m/rad, {name} kp below the limits"
            yield label, mode(settings, elastic, substeps=16)


def stability_map(path: TorquePath = PRINTED, points: int = 41) -> StabilityMap:
    """Growth over 10000 ... 100000 1/s^2 in both directions, k_D as in Table 5-1."""
    machine = plant(path)
    axis = np.geomspace(1e4, 1e5, points)
    growth = np.array([[mode(gains(t, r), machine).growth for t in axis] for r in axis])
    return StabilityMap(kp_translation=axis, kp_rotation=axis, growth=growth)


def study(points: int = 81) -> Study:
    """Everything; a few seconds, most of them for the map."""
    return Study(
        limits={path.name: tuned_gains(path) for path in TORQUE_PATHS},
        trials=trials(),
        map=stability_map(points=points),
    )


def document(result: Study) -> dict[str, Any]:
    """The study as data for JSON."""
    inertia = collar_modes(CDriveParameters()).inertia
    return {
        "question": "Why did resolved acceleration become unstable when k_P^t != k_P^r?",
        "source": "Friedlaender 2015, sections 4.6.2, 4.6.4, Table 5-1, Appendix A",
        "torque_paths": [asdict(path) for path in TORQUE_PATHS],
        "limits": {
            name: [{**asdict(gain), "share": gain.share} for gain in found]
            for name, found in result.limits.items()
        },
        "equivalent_stiffness_Nm_per_rad": {
            "CT translation": TUNED.kp * float(inertia[0]),
            "CT rotation": TUNED.kp * float(inertia[1]),
            "TS translation": TASK_SPACE.kp_translation,
            "TS rotation": TASK_SPACE.kp_rotation,
        },
        "trials": [asdict(trial) for trial in result.trials],
        "map": {key: value.tolist() for key, value in vars(result.map).items()},
        "not_explained": [
            "a loop that becomes unstable because one gain is lowered",
            "why the rotation gain of TS was tuned to 0.7 of its limit only",
        ],
        "assumptions": [
            "the delay of the torque loop is the half sample that the amplifier's maker suggested",
            "latency of the input and output cards and the damping matrix D are not printed",
        ],
    }


def write_study(result: Study, out: Path) -> list[Path]:
    """Write ``resolved_acceleration.json`` and two figures into the folder ``out``."""
    import json

    from .resolved_acceleration_plot import plot_limits, plot_map

    return write_folder(
        out,
        {
            "resolved_acceleration.json": lambda path: path.write_text(
                json.dumps(document(result), indent=1) + "\n", encoding="utf-8"
            ),
            "stability_map.png": lambda path: plot_map(result.map, path),
            "tuned_gains.png": lambda path: plot_limits(result.limits, path),
        },
    )
