"""The toolbox's parallel machines on the rig; axes are those of the sources where they are printed.

5R: Table 4.1 of Roldan, gear 40:1. RePlaLink: gear 10:1 and rotors of section 6.2, friction the mean of both joints.
2-PRR: section 6.1, gear 14:1, 70 mm a turn. Table: section 4.2, gear 15:1, 70 mm a turn, the manufacturers' inertia.
3-PRS: screws of 2 mm a turn. Its flexures pull on the motors with up to 6.7 mN m/rad, a third of the 20 mN m/rad that loops of
100 rad/s make of its small rotors: they gave way by 20 % of the motion. Its loops are twice as fast and add the nominal
pull at the reference; what is left is friction. Assumed: torque constants of RePlaLink and 3-PRS, the axes of the 3-PRS, the travel.
"""

import numpy as np

from .chain import Chain

CHAINS = {
    "5r": Chain(
        kind="five_bar",
        nominal={
            "gear_ratio": 40.0,
            "torque_constant_Nm_per_A": 1.43,
            "rotor_inertia_kg_m2": 13e-4,
            "viscous_Nms_per_rad": 1.7e-3,
            "coulomb_Nm": 0.478,
            "sign_width_rad_per_s": round(1.0 / 10.78, 4),
        },
        mark=(2.2, 0.9),
        travel=0.4,
        speed=0.5,
        count=2.0 * np.pi / 2**14,
        payload=(0.4, 1.0),
    ),
    "replalink": Chain(
        kind="replalink",
        nominal={
            "gear_ratio": 10.0,
            "torque_constant_Nm_per_A": 0.5,
            "rotor_inertia_kg_m2": 4.1e-5,
            "viscous_Nms_per_rad": 0.037,
            "coulomb_Nm": 0.055,
            "sign_width_rad_per_s": 0.5,
        },
        mark=(1.95, 1.2),
        travel=0.3,
        speed=0.4,
        count=2.0 * np.pi / 2**16,
        payload=(0.3, 0.8),
    ),
    "2prr": Chain(
        kind="two_prr",
        nominal={
            "mass1_kg": 0.6,
            "mass2_kg": 0.5,
            "gear_ratio": 14.0,
            "lead_m_per_rev": 0.07,
            "torque_constant_Nm_per_A": 0.0302,
            "rotor_inertia_kg_m2": 1.56e-5,
            "viscous_Nms_per_rad": 3.0e-6,
            "coulomb_Nm": 0.035,
            "sign_width_rad_per_s": 1.0,
        },
        mark=(0.2, 0.25),
        travel=0.08,
        speed=0.1,
        count=2.0 * np.pi / 2000,
        payload=(0.5, 1.5),
    ),
    "mast": Chain(
        kind="mast",
        nominal={
            "gear_ratio": 15.0,
            "lead_m_per_rev": 0.07,
            "torque_constant_Nm_per_A": 0.0302,
            "rotor_inertia_kg_m2": 2.233e-5,
            "viscous_Nms_per_rad": 1.0e-6,
            "coulomb_Nm": 0.01949,
            "sign_width_rad_per_s": 1.0,
        },
        mark=(0.0, 0.0, 0.0),
        travel=0.05,
        speed=0.08,
        count=2.0 * np.pi / 2000,
        payload=(0.5, 1.5),
    ),
    "3prs": Chain(
        kind="three_prs",
        nominal={
            "gear_ratio": 1.0,
            "lead_m_per_rev": 0.002,
            "torque_constant_Nm_per_A": 0.02,
            "rotor_inertia_kg_m2": 2.0e-6,
            "viscous_Nms_per_rad": 1.0e-6,
            "coulomb_Nm": 0.004,
            "sign_width_rad_per_s": 1.0,
        },
        mark=(0.0, 0.0, 0.0),
        travel=0.0018,
        speed=0.003,
        count=2.0 * np.pi / 2**14,
        payload=(0.15, 0.4),
        servo=200.0,
        feed_forward="load",
    ),
}
