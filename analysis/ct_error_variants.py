"""The settings tried to reproduce the printed errors of simulated computed torque (CT).

Each variant simulates all three controllers in all three motions at 2 Hz. ``BASE`` is the block diagram
of Fig. 4-2; a variant changes what its label says and nothing else.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import logm

from ..models import benchmark, c_drive, thesis_tables
from ..models.benchmark import LSB, SETTINGS, Conditions
from ..models.block_loop import BlockController, Wiring
from ..models.c_drive import CDriveParameters
from ..models.c_drive_controllers import ComputedTorque
from ..models.drive_kernels import LoopController
from ..models.observer import ContinuousObserver, DiscreteObserver, continuous_observer
from ..models.thesis_tables import Key

Metrics = dict[Key, float]
CONDITIONS = Conditions()
COUNT = 1.0  # half width of the dead zone [encoder counts]
PRINTED_CT = ComputedTorque()  # gains of Table 5-1
FIG_4_2 = Wiring(lsb=LSB, dead_zone=COUNT * LSB)


@dataclass(frozen=True, kw_only=True)
class Variant:
    """One setting: what is tried, and the simulation of it."""

    group: str
    label: str
    simulate: Callable[[], Metrics]


@dataclass(frozen=True, kw_only=True)
class Setting:
    """The block diagram's choices; the defaults are what reproduces the printed simulation."""

    inertia_factor: float = 0.95  # on M in the controller
    damping_factor: float = 0.95  # on D in the controller
    observer_damping_factor: float | None = None  # on D in the observer, if it differs
    settings: ComputedTorque = PRINTED_CT
    feedforward: float = 1.0  # share of the desired acceleration
    wiring: Wiring = FIG_4_2
    euler_observer: bool = False  # Euler steps of the observer, where position and torque are held

    def controllers(self, parameters: CDriveParameters) -> dict[str, BlockController]:
        """PD, CT and TS for this setting."""
        model = scaled(parameters, self.inertia_factor, self.damping_factor)
        laws = {
            name: benchmark.block_controller(law, model, self.wiring)
            for name, law in {**SETTINGS, "ct": self.settings}.items()
        }
        ct = laws["ct"]
        ct = ct._replace(gains=ct.gains._replace(feedforward=self.feedforward))
        if self.observer_damping_factor is not None:
            believed = scaled(parameters, self.inertia_factor, self.observer_damping_factor)
            ct = ct._replace(observer=continuous_observer(believed, self.settings.poles))
        if self.euler_observer:
            ct = ct._replace(observer=euler_equivalent(ct.observer, CONDITIONS.dt))
        return {**laws, "ct": ct}


BASE = Setting()


def scaled(parameters: CDriveParameters, inertia: float, damping: float) -> CDriveParameters:
    """The drive with M and D multiplied by factors of their own."""
    return replace(
        parameters,
        m11=inertia * parameters.m11,
        m12=inertia * parameters.m12,
        beta=damping * parameters.beta,
        gamma=damping * parameters.gamma,
    )


def block_metrics(setting: Setting, parameters: CDriveParameters) -> Metrics:
    """The benchmark with the block diagram."""
    plant = c_drive.drive(parameters)
    return benchmark.benchmark_metrics(plant, setting.controllers(parameters), CONDITIONS)


def variants(parameters: CDriveParameters) -> Iterator[Variant]:
    """Everything that was tried, group by group."""
    yield from _blocks("as found", parameters, {"continuous blocks, M and D −5 %, dead zone": BASE})
    yield from _blocks("model error", parameters, _model_errors())
    yield from _blocks("dead zone", parameters, _dead_zones())
    yield from _blocks("friction gain c", parameters, _friction_gains(BASE))
    yield from _blocks("friction gain c, held", parameters, _friction_gains(HELD))
    yield from _blocks("friction gain c, held, Euler", parameters, _friction_gains(HELD_EULER))
    yield from _blocks("delays and holds", parameters, _delays())
    yield from _blocks("encoder", parameters, _encoders())
    yield from _blocks("derivative filter", parameters, _filters())
    yield from _blocks("observer", parameters, _observers())
    yield from _blocks("feed-forward and gains", parameters, _gains())
    yield from _sampled(parameters)
    yield from _other_metrics(parameters)


HELD = replace(BASE, wiring=FIG_4_2._replace(hold_position=True, hold_command=True))
HELD_EULER = replace(HELD, euler_observer=True)


def _blocks(
    group: str, parameters: CDriveParameters, settings: dict[str, Setting]
) -> Iterator[Variant]:
    for label, setting in settings.items():
        yield Variant(
            group=group,
            label=label,
            simulate=lambda setting=setting: block_metrics(setting, parameters),  # type: ignore[misc]
        )


def _wired(**changes: Any) -> Setting:
    return replace(BASE, wiring=BASE.wiring._replace(**changes))


def _model_errors() -> dict[str, Setting]:
    found = {}
    for dead_zone, note in ((COUNT * LSB, ""), (0.0, ", no dead zone")):
        for m in (0.95, 1.0, 1.05):
            for d in (0.95, 1.0, 1.05):
                if (m, d, note) != (0.95, 0.95, ""):
                    found[f"M × {m:g}, D × {d:g}{note}"] = replace(
                        _wired(dead_zone=dead_zone), inertia_factor=m, damping_factor=d
                    )
    return found


def _dead_zones() -> dict[str, Setting]:
    return {f"{n:g} counts": _wired(dead_zone=n * LSB) for n in (0.0, 0.5, 0.75, 1.25, 1.5, 2.0)}


def _friction_gains(base: Setting) -> dict[str, Setting]:
    return {
        f"c = {c:g}": replace(base, settings=ComputedTorque(friction_compensation=c))
        for c in (0.0, 0.3, 0.4, 0.5, 0.8, 1.0, 1.2)
        if base is not BASE or c != 0.4
    }


def _delays() -> dict[str, Setting]:
    return {
        "no unit delay": _wired(observer_late=False),
        "torque held over the step": _wired(hold_command=True),
        "position held over the step": _wired(hold_position=True),
        "position and torque held, no dead zone": _wired(
            hold_position=True, hold_command=True, dead_zone=0.0
        ),
        "position one step late, torque held": _wired(position_late=True, hold_command=True),
    }


def _encoders() -> dict[str, Setting]:
    return {
        "exact": _wired(lsb=0.0),
        "rounded down": _wired(encoder_shift=-0.5 * LSB),
        "rounded down, no dead zone": _wired(encoder_shift=-0.5 * LSB, dead_zone=0.0),
        "12 bit": _wired(lsb=2.0 * LSB),
        "12 bit, no dead zone": _wired(lsb=2.0 * LSB, dead_zone=0.0),
    }


def _filters() -> dict[str, Setting]:
    return {
        "r' − F(s) q in place of F(s) e, no dead zone": _wired(filter_position=True, dead_zone=0.0),
        **{
            f"CT with N = {n:g} rad/s": replace(BASE, settings=ComputedTorque(cutoff=n))
            for n in (300.0, 1200.0)
        },
    }


def _observers() -> dict[str, Setting]:
    return {
        **{
            f"poles at {pole:g} rad/s": replace(BASE, settings=ComputedTorque(poles=(pole, pole)))
            for pole in (-60.0, -300.0, -1200.0)
        },
        **{
            f"D × {factor:g} in the observer only": replace(BASE, observer_damping_factor=factor)
            for factor in (0.5, 1.05, 2.0)
        },
    }


def _gains() -> dict[str, Setting]:
    return {
        "no acceleration feed-forward": replace(BASE, feedforward=0.0),
        "feed-forward × 0.95": replace(BASE, feedforward=0.95),
        "CT kd = 0": replace(BASE, settings=ComputedTorque(kd=0.0)),
        "CT kd = 110 1/s": replace(BASE, settings=ComputedTorque(kd=110.0)),
        "CT kp × 0.5": replace(BASE, settings=ComputedTorque(kp=17500.0)),
        "CT kp = kd² / 4, critically damped": replace(
            BASE, settings=ComputedTorque(kp=55.0**2 / 4.0)
        ),
    }


def _sampled(parameters: CDriveParameters) -> Iterator[Variant]:
    """The sampled loop without dead zone, by discretisation of the observer and sign of the error."""
    orders = {"Euler": 1, "RK4, inputs held": 4, "exact for held inputs": 0}
    for factor in (1.05, 0.95):
        for name, order in orders.items():
            yield Variant(
                group="sampled loop",
                label=f"observer {name}; M and D × {factor:g}",
                simulate=lambda order=order, factor=factor: benchmark.benchmark_metrics(  # type: ignore[misc]
                    c_drive.drive(parameters),
                    _sampled_controllers(parameters, factor, order),
                    CONDITIONS,
                ),
            )


def _sampled_controllers(
    parameters: CDriveParameters, factor: float, order: int
) -> dict[str, LoopController]:
    controllers = benchmark.sampled_controllers(parameters, model_factor=factor)
    if order:
        discrete = taylor_observer(parameters.scaled_model(factor), CONDITIONS.dt, order)
        controllers["ct"] = controllers["ct"]._replace(**discrete._asdict())
    return controllers


def taylor_observer(model: CDriveParameters, dt: float, order: int) -> DiscreteObserver:
    """The observer for held inputs by a Runge-Kutta method of ``order`` up to 4: exp(U dt) cut off."""
    observer = continuous_observer(model, ComputedTorque().poles)
    term = np.eye(2)
    transition, held = np.eye(2), np.zeros((2, 2))
    for k in range(1, order + 1):
        held = held + dt * term / k
        term = term @ observer.from_state * dt / k
        transition = transition + term
    return DiscreteObserver(
        transition=transition,
        from_position=held @ observer.from_position,
        from_torque=held @ observer.from_torque,
        rate_from_state=observer.rate_from_state,
        rate_from_position=observer.rate_from_position,
    )


def euler_equivalent(observer: ContinuousObserver, dt: float) -> ContinuousObserver:
    """The continuous observer whose step for held inputs is the Euler step of ``observer``.

    With exp(U' dt) = 1 + U dt and the inputs scaled to match; needs 1 + U dt positive definite.
    """
    transition = np.eye(2) + dt * observer.from_state
    state = np.real(logm(transition)) / dt
    scale = np.linalg.solve(transition - np.eye(2), state) * dt
    return observer._replace(
        from_state=state,
        from_position=scale @ observer.from_position,
        from_torque=scale @ observer.from_torque,
    )


def _other_metrics(parameters: CDriveParameters) -> Iterator[Variant]:
    """The maximum over a cycle reported in place of the RMS, in both loops."""
    sampled = benchmark.sampled_controllers(parameters)
    blocks = replace(BASE, wiring=BASE.wiring._replace(dead_zone=0.0)).controllers(parameters)
    for name, controllers in (("sampled, M and D +5 %", sampled), ("blocks, −5 %", blocks)):
        yield Variant(
            group="metric",
            label=f"errors as maxima; {name}, no dead zone",
            simulate=lambda controllers=controllers: _maxima_as_rms(  # type: ignore[misc]
                benchmark.benchmark_metrics(c_drive.drive(parameters), controllers, CONDITIONS)
            ),
        )


def _maxima_as_rms(metrics: Metrics) -> Metrics:
    return {
        (controller, motion_name, metric): metrics[
            controller, motion_name, metric.replace("_rms_", "_max_")
        ]
        if metric in (thesis_tables.E_U_RMS, thesis_tables.E_THETA_RMS)
        else value
        for (controller, motion_name, metric), value in metrics.items()
    }
