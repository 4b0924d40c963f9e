"""The 2PRU-1PRS table near home with the identified axes of Roldan, logged as if described by the manufacturers.

Shares no code with the instrument: a constant mass matrix in (z, tilt, tilt) carried to three sliders, axes with Coulomb
friction, a sampled cascade, semi-implicit steps of 50 microseconds, encoders of 2000 counts a turn.
"""

import numpy as np
import yaml

PER_MOTOR = 0.1 / (2.0 * np.pi * 15.0)  # [m/rad]
DRIVING, DRIVEN = 2.028e-5, 2.096e-6  # J_1 and J_2 of the manufacturers [kg m^2]
SHARE, COULOMB, COULOMB_STATED = 1.0 / 1.56, 7.18e-2, 1.949e-2
PLATFORM, BAR, RADIUS = 2.06, 0.07, 0.35
CONSTANT, COUNT, DT = 0.0302, 2.0 * np.pi / 2000, 1e-3
WIDTH = 1.0  # of the smoothed sign [rad/s]


def motor_inertia():
    """Of the three axes with the table on them (3, 3) [kg m^2]."""
    azimuth = np.deg2rad([0.0, 90.0, 180.0])
    lift = np.column_stack([np.ones(3), RADIUS * np.sin(azimuth), -RADIUS * np.cos(azimuth)])
    disc = PLATFORM * RADIUS**2 / 4.0
    into = np.linalg.inv(lift)
    table = into.T @ np.diag([PLATFORM, disc, disc]) @ into + BAR * np.eye(3)
    weight = into.T @ np.array([PLATFORM * 9.81, 0.0, 0.0]) + BAR * 9.81
    own = SHARE * DRIVING + DRIVEN
    return own * np.eye(3) + PER_MOTOR**2 * table, PER_MOTOR * weight


def run(frequency, cycles):
    """Columns t, references, positions (3) [m] and currents (3) [A] of a sine in z of 5 mm."""
    matrix, load = motor_inertia()
    inverse = np.linalg.inv(matrix)
    n = round(cycles / frequency / DT)
    t = DT * np.arange(n)
    wave = 5e-3 * np.sin(2.0 * np.pi * frequency * t)
    angle, rate = np.zeros(3), np.zeros(3)
    kp = 400.0 * 2.24e-5
    integral = load / (20.0 * kp)
    position, current = np.empty((n, 3)), np.empty((n, 3))
    before = angle.copy()
    for k in range(n):
        seen = COUNT * np.round(angle / COUNT)
        position[k] = PER_MOTOR * seen
        speed = (seen - before) / DT
        before = seen
        error = 24.0 * (wave[k] / PER_MOTOR - seen) - speed
        torque = kp * (error + 20.0 * integral)
        integral = integral + DT * error
        current[k] = torque / CONSTANT
        for _ in range(20):
            net = torque - load - COULOMB * np.tanh(rate / WIDTH)
            rate = rate + DT / 20 * inverse @ net
            angle = angle + DT / 20 * rate
    return np.column_stack([t, np.tile(wave[:, None], 3), position, current])


def write_log_set(folder):
    """Runs at the printed 0.4, 5 and 10 Hz, and one at 2 Hz to validate on."""
    folder.mkdir(parents=True, exist_ok=True)
    names = [f"q{i}_ref" for i in (1, 2, 3)] + [f"q{i}" for i in (1, 2, 3)]
    currents = [f"current{i}" for i in (1, 2, 3)]
    entries = []
    plan = ((0.4, 2, "fit"), (5.0, 5, "fit"), (10.0, 10, "fit"), (2.0, 4, "validate"))
    for i, (frequency, cycles, use) in enumerate(plan):
        np.savetxt(
            folder / f"run{i + 1}.csv", run(frequency, cycles), delimiter=",", comments="",
            fmt="%.12f", header=",".join(["t", *names, *currents]),
        )  # fmt: skip
        entries.append(
            {"file": f"run{i + 1}.csv", "rate_Hz": frequency, "use": use, "controller": "cascade"}
        )
    document = {
        "format": 1,
        "name": "mast, as the manufacturers describe it",
        "system": {
            "kind": "mast",
            "nominal": {
                "gear_ratio": 15.0, "lead_m_per_rev": 0.1, "torque_constant_Nm_per_A": CONSTANT,
                "rotor_inertia_kg_m2": DRIVING + DRIVEN, "viscous_Nms_per_rad": 0.0,
                "coulomb_Nm": COULOMB_STATED, "sign_width_rad_per_s": WIDTH,
            },
        },
        "controllers": {"cascade": {"kind": "not stated"}},
        "sample_time_s": DT,
        "columns": {"t": "s", **dict.fromkeys(names, "m"), **dict.fromkeys(currents, "A")},
        "runs": entries,
    }  # fmt: skip
    (folder / "logset.yaml").write_text(yaml.safe_dump(document, sort_keys=False))
    return folder
