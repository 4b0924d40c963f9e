"""Nominal model of PepperMill-Carrier log sets (``system.kind: pmc``), as ``gapscope simulate pmc`` writes them."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from ....models.pmc.control import Controller
from ....models.pmc.controllers import CONTROLLERS, Settings, controller
from ....models.pmc.parameters import PMCParameters
from ....models.pmc.prediction import MOTORS
from ...errors import InputError
from ..carrier_machine import CarrierMachine, CarrierRun, joints_of, own_parameters, poses_of
from ..checks import finite_number, shown
from ..description import FILE
from ..logset import LogSet, Run
from ..machine import RunData, encoder_step
from .encoders import whole_bits
from .reference import derivatives
from .settings import Settings as Keys
from .settings import require_units, run_settings, tolerance

RIPPLES_PER_TURN = (1, 2, 4, 6, 8, 12)  # torque ripple periods of a motor to look for
RUN_KEYS = ("speed", "placement")


def read(logset: LogSet) -> tuple[CarrierMachine, list[RunData]]:
    """Machine and runs of a PepperMill-Carrier log set."""
    units = {f"psi_{m}{end}": "rad" for m in MOTORS for end in ("", "_ref")}
    require_units(logset, units | {f"tau_{m}": "N m" for m in MOTORS})
    where = f"{logset.folder / FILE}, system"
    known = {"kind", "nominal", "home", "tolerance", "limits", "description", "note"}
    system = Keys(where, logset.system, known)
    parameters = _parameters(logset.system.get("nominal", {}), where)
    home = _home(system)
    laws = {
        name: _controller(
            values, f"{logset.folder / FILE}, controllers.{name}", parameters, home, logset.dt
        )
        for name, values in logset.controllers.items()
    }
    runs = [_run(run, logset, laws[run.controller], home, parameters) for run in logset.runs]
    reached = np.concatenate([joints_of(run.position, home, parameters) for run in runs])
    machine = CarrierMachine(
        kind="pmc",
        joints=MOTORS,
        position_unit="rad",
        effort_unit="N m",
        own=own_parameters(parameters, tolerance(logset)),
        parameters=parameters,
        home=home,
        middle=0.5 * (reached.min(axis=0) + reached.max(axis=0)),
        ripples={f"1/{k} turn" if k > 1 else "1 turn": float(k) for k in RIPPLES_PER_TURN},
    )
    return machine, list(runs)


def _parameters(nominal: Any, where: str) -> PMCParameters:
    if not isinstance(nominal, Mapping):
        raise InputError(f"{where}.nominal", shown(nominal), "a mapping of parameters")
    values = {key: value for key, value in nominal.items() if key != "note"}
    _check_numbers(f"{where}.nominal", values)
    if values.get("encoder_bits"):  # 0 is an exact encoder
        whole_bits(f"{where}.nominal.encoder_bits", str(values["encoder_bits"]))
    try:
        return PMCParameters.from_mapping(values, f"{where}.nominal")
    except (ValueError, TypeError) as error:
        raise InputError(
            f"{where}.nominal", str(error), "fields of PMCParameters, each with its number"
        ) from None


def _check_numbers(where: str, values: Mapping[Any, Any]) -> None:
    """Refuse what is no finite number in a mapping, and in the mappings and lists inside it."""
    for key, value in values.items():
        if isinstance(value, Mapping):
            _check_numbers(f"{where}.{key}", value)
            continue
        for one in value if isinstance(value, list) else [value]:
            finite_number(f"{where}.{key}", one)


def _home(system: Keys) -> Any:
    """Joints d1, d2 [m], theta1, theta2 [rad] at which all motor angles are logged as zero."""
    if not isinstance(system.values.get("home"), list) or len(system.values["home"]) != 4:
        raise InputError(
            f"{system.where}.home", shown(system.values.get("home")),
            "four joints d1, d2 [m], theta1, theta2 [rad]",
            "They are the joints at which all motor angles are logged as zero.",
        )  # fmt: skip
    return system.numbers("home", 4)


def _controller(
    values: Mapping[str, Any], where: str, parameters: PMCParameters, home: Any, dt: float
) -> Controller:
    kind = values.get("kind")
    if not isinstance(kind, str) or kind not in CONTROLLERS:
        raise InputError(f"{where}.kind", shown(kind), f"one of {', '.join(CONTROLLERS)}")
    default = CONTROLLERS[kind]
    keys = Keys(
        where, values, {item.name for item in fields(default)} | {"kind", "model_error", "note"}
    )
    _check_numbers(where, {k: v for k, v in values.items() if k not in ("kind", "note")})
    gains: dict[str, Any] = {
        item.name: tuple(values[item.name])
        if isinstance(values[item.name], list)
        else values[item.name]
        for item in fields(default)
        if item.name in values
    }
    try:
        law: Any = type(default)  # whose defaults are those of CONTROLLERS
        settings: Settings = law(**gains)
        believed = parameters.heavier(keys.number("model_error", 0.0))
        return controller(settings, believed, home, dt)
    except (ValueError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(where, str(error), "gains of this controller") from None


def _run(
    run: Run, logset: LogSet, law: Controller, home: Any, parameters: PMCParameters
) -> CarrierRun:
    keys = run_settings(logset, run, *RUN_KEYS)
    keys.number("speed", 1.0)
    placement = run.settings.get("placement", {})
    if not isinstance(placement, Mapping):
        raise InputError(f"{keys.where}.placement", shown(placement), "a mapping of numbers")
    _check_numbers(f"{keys.where}.placement", placement)
    reference = run.stack(*(f"psi_{m}_ref" for m in MOTORS))
    position = run.stack(*(f"psi_{m}" for m in MOTORS))
    rate, acceleration = derivatives(reference, logset.dt)
    joints = joints_of(reference, home, parameters)
    pose = poses_of(joints, parameters)
    for what, reached in (
        ("psi_*_ref", pose),
        ("psi_*", poses_of(joints_of(position, home, parameters), parameters)),
    ):
        lost = np.flatnonzero(~np.isfinite(reached).all(axis=1))
        if lost.size:
            raise InputError(
                f"{keys.where}, row {lost[0] + 2}, columns {what}",
                "motor angles outside the reach of the limbs",
                "angles counted from system.home by a robot of system.nominal",
            )
    return CarrierRun(
        name=run.name,
        use=run.use,
        settings=run.settings,
        dt=logset.dt,
        t=run.columns["t"],
        reference=reference,
        reference_rate=rate,
        reference_acceleration=acceleration,
        position=position,
        command=run.stack(*(f"tau_{m}" for m in MOTORS)),
        controller=law,
        period=keys.period(logset.dt),
        lsb=encoder_step(position),
        start=keys.start,
        joints=joints,
        joint_acceleration=derivatives(joints, logset.dt)[1],
        pose=pose,
        pose_acceleration=derivatives(pose, logset.dt)[1],
    )
