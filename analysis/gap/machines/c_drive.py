"""Nominal model of C-drive log sets (``system.kind: c_drive``)."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ....models import c_drive
from ....models.c_drive import CDriveParameters
from ....models.c_drive_controllers import PD, ComputedTorque, TaskSpacePD, loop_controller
from ....models.drive import VISCOUS
from ....models.drive_kernels import LoopController
from ....models.motion import C_DRIVE_MOTIONS, c_drive_motion
from ...errors import InputError
from ..checks import shown
from ..description import FILE
from ..drive_machine import DriveMachine, DrivePlant, PayloadAxis
from ..logset import LogSet, Run
from ..machine import RunData, encoder_step, own_parameter
from .reference import derivatives
from .settings import Settings, nominal_settings, require_units, run_settings, tolerance

COLUMNS = {
    "psi_L_ref": "rad", "psi_R_ref": "rad", "psi_L": "rad", "psi_R": "rad",
    "tau_L": "Nm", "tau_R": "Nm",
}  # fmt: skip
REFERENCE_ROUNDING = 1e-5  # [rad], how far a printed reference may be from its motion program
RIPPLES_PER_TURN = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 18, 24)  # eccentricity, poles, slots
ROTOR_INERTIA = 6.0e-4  # I_h [kg m^2]: (5.2) with the printed collar mass of 3.279 kg in (2.6a)

# Keys of ``system.nominal`` and the parameters they name.
NOMINAL = {
    "lead_m_per_rev": "lead",
    "m11_kg_m2": "m11",
    "m12_kg_m2": "m12",
    "beta_N_m_s": "beta",
    "gamma_N_m_s": "gamma",
    "delta_N_m": "delta",
    "eta_N_m": "eta",
}
POSITIVE = ("lead", "m11")
LEAST = dict.fromkeys(("beta", "gamma", "delta", "eta"), 0.0)  # of friction


def read(logset: LogSet) -> tuple[DriveMachine, list[RunData]]:
    """Machine and runs of a C-drive log set."""
    require_units(logset, COLUMNS)
    parameters = _parameters(logset)
    controllers = {
        name: read_controller(
            f"{logset.folder / FILE}, controllers.{name}", settings, parameters, logset.dt
        )
        for name, settings in logset.controllers.items()
    }
    machine = c_drive_machine(parameters, tolerance(logset))
    runs = [_run_data(run, logset.dt, controllers[run.controller], logset) for run in logset.runs]
    return machine, runs


def c_drive_machine(parameters: CDriveParameters, relative: float) -> DriveMachine:
    """The C-drive for the instrument; its own parameters are the modal inertias and D."""
    M = c_drive.inertia_matrix(parameters)
    J = c_drive.jacobian(parameters.lead)
    sliding = J[:1].T @ J[:1]  # inertia of one kilogram of collar, eq. (2.6a)
    turning = J[1:].T @ J[1:] * (2.0 * np.pi / parameters.lead) ** 2
    own = {
        "inertia_translation": ("kg m^2", M[0, 0] - M[0, 1]),
        "inertia_rotation": ("kg m^2", M[0, 0] + M[0, 1]),
        # Each motor has bearings of its own: the tolerance is theirs, not that of their mean.
        "beta_left": ("N m s/rad", parameters.beta),
        "beta_right": ("N m s/rad", parameters.beta),
        "gamma": ("N m s/rad", parameters.gamma),
    }

    def build(values: Mapping[str, float]) -> DrivePlant:
        slide, turn = values["inertia_translation"], values["inertia_rotation"]
        inertia = 0.5 * np.array([[turn + slide, turn - slide], [turn - slide, turn + slide]])
        plant = DrivePlant(inertia=inertia, drive=c_drive.drive(parameters).copy())
        plant.drive.element[:, VISCOUS] = [
            values["beta_left"],
            values["beta_right"],
            0.5 * values["gamma"],
        ]
        return plant

    return DriveMachine(
        kind="c_drive",
        joints=c_drive.SHAFTS,
        elements=c_drive.ELEMENTS,
        task=("translation", "rotation"),
        task_map=J * np.array([[1.0], [2.0 * np.pi / parameters.lead]]),
        position_unit="rad",
        effort_unit="N m",
        own=tuple(own_parameter(name, unit, v, relative) for name, (unit, v) in own.items()),
        payload=(
            PayloadAxis(
                name="collar_mass", unit="kg", inertia=sliding, own="inertia_translation", scale=1.0
            ),
            PayloadAxis(
                name="collar_inertia", unit="kg m^2", inertia=turning, own="inertia_rotation",
                scale=2e-3,
            ),
        ),
        viscous_own=("beta_left", "beta_right", "gamma"),
        ripples={f"1/{k} turn" if k > 1 else "1 turn": float(k) for k in RIPPLES_PER_TURN},
        motor_share=ROTOR_INERTIA / (M[0, 0] - M[0, 1]),
        bandwidth=100.0,
        plant=build,
    )  # fmt: skip


def _parameters(logset: LogSet) -> CDriveParameters:
    nominal = nominal_settings(logset, set(NOMINAL))
    return read_parameters(f"{logset.folder / FILE}, system.nominal", nominal)


def read_parameters(where: str, nominal: Settings) -> CDriveParameters:
    """Parameters from ``system.nominal``; InputError for those of no real drive."""
    default = CDriveParameters()
    try:
        return CDriveParameters(
            **{
                name: nominal.number(
                    key, getattr(default, name), positive=name in POSITIVE, least=LEAST.get(name)
                )
                for key, name in NOMINAL.items()
            }
        )
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(where, str(error), "parameters of a real drive") from None


FILTER = "derivative_filter_rad_per_s"
KEYS: dict[str, set[str]] = {
    "pd": {"kp_Nm_per_rad", "kd_Nms_per_rad", "ki_Nm_per_rad_s"},
    "task_space_pd": {
        "kp_trans_Nm_per_rad", "kp_rot_Nm_per_rad", "kd_trans_Nms_per_rad", "kd_rot_Nms_per_rad",
    },
    "computed_torque": {
        "kp_per_s2", "kd_per_s", "kp_rot_per_s2", "kd_rot_per_s", "observer_pole_rad_per_s",
        "friction_compensation",
    },
}  # fmt: skip


def read_controller(
    where: str, values: Mapping[str, Any], model: CDriveParameters, dt: float
) -> LoopController:
    """Controller from its block of a log set, ``dt`` [s] its period; InputError for a bad key."""
    kind = values.get("kind")
    if not isinstance(kind, str) or kind not in KEYS:
        raise InputError(f"{where}.kind", shown(kind), f"one of {', '.join(sorted(KEYS))}")
    s = Settings(where, values, KEYS[kind] | {"kind", FILTER})
    cutoff = s.number(FILTER, positive=True)
    settings: PD | TaskSpacePD | ComputedTorque
    if kind == "pd":
        settings = PD(
            kp=s.number("kp_Nm_per_rad", least=0.0),
            kd=s.number("kd_Nms_per_rad", least=0.0),
            ki=s.number("ki_Nm_per_rad_s", 0.0, least=0.0),
            cutoff=cutoff,
        )
    elif kind == "task_space_pd":
        settings = TaskSpacePD(
            kp_translation=s.number("kp_trans_Nm_per_rad", least=0.0),
            kp_rotation=s.number("kp_rot_Nm_per_rad", least=0.0),
            kd_translation=s.number("kd_trans_Nms_per_rad", least=0.0),
            kd_rotation=s.number("kd_rot_Nms_per_rad", least=0.0),
            cutoff=cutoff,
        )
    else:
        pole = s.number("observer_pole_rad_per_s")
        kp, kd = s.number("kp_per_s2", least=0.0), s.number("kd_per_s", least=0.0)
        settings = ComputedTorque(
            kp=kp,
            kd=kd,
            kp_rotation=s.number("kp_rot_per_s2", kp, least=0.0),
            kd_rotation=s.number("kd_rot_per_s", kd, least=0.0),
            cutoff=cutoff,
            poles=(pole, pole),
            friction_compensation=s.number("friction_compensation"),
        )
    try:
        return loop_controller(settings, model, dt)
    except ValueError as error:
        raise InputError(where, str(error), "a controller that can be built") from None


def _run_data(run: Run, dt: float, controller: LoopController, logset: LogSet) -> RunData:
    settings = run_settings(logset, run)
    t = run.columns["t"]
    reference = run.stack("psi_L_ref", "psi_R_ref")
    rate, acceleration = derivatives(reference, dt)
    if "motion" in run.settings:
        motion = str(run.settings["motion"])
        if motion not in C_DRIVE_MOTIONS:
            raise InputError(
                f"{settings.where}.motion",
                shown(motion),
                f"one of {', '.join(sorted(C_DRIVE_MOTIONS))}",
            )
        if "rate_Hz" in run.settings or settings.seconds is None:
            rate_hz = settings.number("rate_Hz", positive=True)
        else:
            rate_hz = 1.0 / settings.seconds
        exact, exact_rate, exact_acceleration = c_drive_motion(motion, rate_hz).sample(t - t[0])
        # A log may use another program under the same name; then the logged reference is what counts.
        if np.max(np.abs(exact - reference)) < REFERENCE_ROUNDING:
            rate, acceleration = exact_rate, exact_acceleration
    position = run.stack("psi_L", "psi_R")
    return RunData(
        name=run.name,
        use=run.use,
        settings=run.settings,
        dt=dt,
        t=t,
        reference=reference,
        reference_rate=rate,
        reference_acceleration=np.ascontiguousarray(acceleration),
        position=position,
        command=run.stack("tau_L", "tau_R"),
        controller=controller,
        period=settings.period(dt),
        lsb=encoder_step(position),
        start=settings.start,
    )
