"""A small readable log set of every kind of machine, of made-up numbers: for tests of reading, not of physics."""

import copy

import numpy as np
import yaml

from .test_model_file import urdf

N = 300
DT = 0.002
AXES = {
    "torque_constant_Nm_per_A": 0.1, "rotor_inertia_kg_m2": 1e-3, "viscous_Nms_per_rad": 1e-2,
    "coulomb_Nm": 0.1, "sign_width_rad_per_s": 0.1,
}  # fmt: skip
CASCADE = {
    "kind": "cascade_p_p", "kp_per_s": 160.0, "kv_V_per_m_per_s": 243.0, "saturation_V": 10.0,
    "force_per_volt_N": 35.0, "encoder_lsb_m": 1e-6,
}  # fmt: skip
PD = {
    "kind": "pd", "kp_Nm_per_rad": 45.0, "kd_Nms_per_rad": 0.1, "derivative_filter_rad_per_s": 600.0,
}  # fmt: skip
LAW = "u_fb=-(6*e_t+1.8*D(e_t))-(30*e_a+2.5*D(e_a)), D=50 s/(s+50), u=clip(u_fb+u_ff,-10,10)"
PMC_HOME = [0.4, 0.2, 0.18, 1.367]


def _linkage(kind, marks, unit, reach, **nominal):
    """A closed chain with its joints about their marks."""
    columns = {}
    for i, mark in enumerate(marks, start=1):
        columns[f"q{i}_ref"] = (unit, mark, reach)
        columns[f"q{i}"] = (unit, mark, 0.9 * reach)
        columns[f"current{i}"] = ("A", 0.0, 1.0)
    return {
        "system": {"kind": kind, "nominal": {**AXES, **nominal}},
        "controller": {"kind": "pid"},
        "columns": columns,
    }


def _motors(names, unit, effort):
    return {
        **{f"{n}_ref": (unit, 0.0, 0.2) for n in names},
        **dict.fromkeys(names, (unit, 0.0, 0.19)),
        **dict.fromkeys(
            [effort[0].format(n.partition("_")[2]) for n in names], (effort[1], 0.0, 1.0)
        ),
    }


# Columns are (unit, middle, amplitude) of a sine.
KINDS = {
    "slider": {
        "system": {"kind": "slider", "nominal": {"mass_kg": 95.0, "viscous_N_s_per_m": 203.0}},
        "controller": CASCADE,
        "columns": {"q_ref": ("m", 0, 0.1), "q": ("m", 0, 0.09), "force": ("N", 0, 50.0)},
    },
    "c_drive": {
        "system": {"kind": "c_drive", "nominal": {"beta_N_m_s": 4e-3, "gamma_N_m_s": 3e-3}},
        "controller": PD,
        "columns": _motors(("psi_L", "psi_R"), "rad", ("tau_{}", "Nm")),
    },
    "furuta": {
        "system": {"kind": "furuta", "nominal": {"m": 0.024}},
        "controller": {"law": LAW},
        "columns": {
            "theta_ref": ("rad", 0, 0.2), "alpha_ref": ("rad", 0, 0.0), "theta": ("rad", 0, 0.2),
            "alpha": ("rad", 0, 0.1), "u": ("V", 0, 1.0),
        },
    },
    "five_bar": _linkage("five_bar", (2.2, 0.9), "rad", 0.1, mass5_kg=0.5, base_m=0.2),
    "replalink": _linkage("replalink", (1.95, 1.2), "rad", 0.1, mass5_kg=0.5),
    "two_prr": _linkage("two_prr", (0.2, 0.25), "m", 0.01, lead_m_per_rev=0.01, mass1_kg=5.0,
                        mass2_kg=5.0, inertia3_kg_m2=0.04, bar_m=0.654),
    "mast": _linkage("mast", (0.0, 0.0, 0.0), "m", 0.01, lead_m_per_rev=0.005, bar_mass_kg=0.5),
    "three_prs": _linkage("three_prs", (0.0, 0.0, 0.0), "m", 0.0005, lead_m_per_rev=0.001,
                          revolute_stiffness_Nm_per_rad=0.5),
    "pmc": {
        "system": {"kind": "pmc", "home": PMC_HOME,
                   "nominal": {"payload": 0.1, "drive": {"beta": 4e-3}, "encoder_bits": 13}},
        "controller": {"kind": "pd", "kp": 45.0, "kd": 0.1, "cutoff": 600.0},
        "columns": _motors(("psi_L1", "psi_R1", "psi_L2", "psi_R2"), "rad", ("tau_{}", "N m")),
    },
    "pendulum": {
        "system": {"kind": "pendulum", "mass_kg": 0.5, "length_m": 0.1},
        "controller": {"kind": "servo_position"},
        "columns": {
            "q_ref": ("rad", 0, 0.5), "q": ("rad", 0, 0.4), "volts": ("V", 7.4, 0.01),
            "load_raw": ("firmware units", 100, 50), "torque_enable": ("0/1", 1, 0),
        },
        "run": {"kp": 100},
    },
    "serial_arm": {
        "system": {"kind": "serial_arm", "joints": ["pitch", "elbow"],
                   "parallel_axes": ["pitch", "-elbow"],
                   "nominal": {"time_constant_s": 0.03, "inertia_s2": 1e-3, "delay_s": 0.02}},
        "controller": {"kind": "servo_position"},
        "columns": {
            "JOINT_ref": ("rad", 0, 0.5), "JOINT": ("rad", 0, 0.4), "JOINT_abs_torque": ("N m", 1, 0.5),
        },
    },
    "piezo_stack": {
        "system": {"kind": "piezo_stack",
                   "nominal": {"gain_um_per_V": 0.1, "offset_um": 0.0, "rest_V": 0.0}},
        "controller": {"kind": "open_loop"},
        "columns": {"u": ("V", 50, 50), "y": ("um", 5, 5)},
    },
    "mm3a": {
        "system": {"kind": "mm3a", "nominal": {
            "joint_3_positive": {"basic": 9.72e-7, "recoil": 0.27, "load": 3.76e-7},
            "arm": {"mass_3": 0.002}, "repeatability": 0.003, "law_error": 0.004,
        }},
        "columns": {
            "steps": ("1", 200, 0), "q1": ("rad", 0, 0), "q2": ("rad", 0, 0), "q3": ("m", 0.005, 0),
            "moved": ("rad or m", 2e-4, 1e-5),
        },
        "run": {"joint": 3, "theta_rad": 0.0, "psi_rad": 0.0, "session": "day",
                "force_N": [0.0, 0.0, 0.0], "run_in_steps": 8},
    },
    "model_file": {
        "system": {"model": "arm.urdf", "joints": ["shoulder"], "payload": {"point": [0.2, 0, 0]},
                   "torque_constant": {"shoulder": 1.5}},
        "controller": {"kind": "joint_pd", "kp": [90], "kd": [6], "gravity_compensation": True},
        "columns": {"JOINT_ref": ("rad", 0, 0.5), "JOINT": ("rad", 0, 0.4), "JOINT_current": ("A", 0, 1.0)},
    },
}  # fmt: skip


def document(kind):
    """``logset.yaml`` of a kind, as a dictionary of its own."""
    given = copy.deepcopy(KINDS[kind])
    run = {**given.pop("run", {}), "rate_Hz": 5.0, "start_s": 0.0, "motion": "translation"}
    return {
        "format": 1,
        "name": kind,
        "sample_time_s": DT,
        **given,
        "columns": {"t": "s", **{n: unit for n, (unit, *_) in given["columns"].items()}},
        "runs": [
            {"file": "run1.csv", "use": "fit", **run},
            {"file": "run2.csv", "use": "validate", **copy.deepcopy(run)},
        ],
    }


def table(kind, seed=0):
    """Columns of a run by name."""
    given = KINDS[kind]
    joints = given["system"].get("joints", ["JOINT"])
    t = DT * np.arange(N)
    noise = np.random.default_rng(seed)
    found = {"t": t}
    for name, (_, middle, amplitude) in given["columns"].items():
        for joint in joints if "JOINT" in name else [""]:
            wave = np.sin(2.0 * np.pi * 5.0 * t + len(found)) + 0.01 * noise.normal(size=N)
            found[name.replace("JOINT", joint)] = middle + amplitude * wave
    return found


def in_memory(kind, change=None, change_table=None):
    """Document and tables of a log set, after ``change`` of the first and ``change_table`` of the first table."""
    frames = {f"run{i}.csv": table(kind, seed=i) for i in (1, 2)}
    if change_table:
        change_table(frames["run1.csv"])
    made = document(kind)
    if change:
        change(made)
    return made, frames


def write(kind, folder, change=None, change_table=None):
    """The same in ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "arm.urdf").write_text(urdf())
    made, frames = in_memory(kind, change, change_table)
    for file, columns in frames.items():
        np.savetxt(
            folder / file, np.column_stack(list(columns.values())), delimiter=",",
            header=",".join(columns), comments="", fmt="%.9g",
        )  # fmt: skip
    (folder / "logset.yaml").write_text(yaml.safe_dump(made, sort_keys=False))
    return folder
