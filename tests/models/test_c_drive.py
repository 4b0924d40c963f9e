"""C-drive: kinematics and dynamics of Friedlaender 2015, section 2.1.1."""

import numpy as np
import pytest

from gapscope.models import c_drive, motion
from gapscope.models.c_drive import CDriveParameters

P = CDriveParameters()


def test_jacobian_is_isotropic_as_in_eq_2_3():
    J = c_drive.jacobian(P.lead)
    np.testing.assert_allclose(J.T @ J, P.lead**2 / (8 * np.pi**2) * np.eye(2), atol=1e-18)
    np.testing.assert_allclose(J @ c_drive.inverse_jacobian(P.lead), np.eye(2), atol=1e-15)


@pytest.mark.parametrize(
    ("name", "translation_mm", "rotation"),
    [("translation", -200.0, 0.0), ("rotation", 0.0, np.pi), ("helical", -100.0, np.pi / 2)],
)
def test_lead_of_60_mm_gives_the_strokes_of_table_5_2(name, translation_mm, rotation):
    psi, _, _ = motion.c_drive_motion(name, 1.0).sample(0.5)
    pose = c_drive.collar_pose(psi, P.lead)
    np.testing.assert_allclose(pose, [1e-3 * translation_mm, rotation], atol=1e-12)


def test_pose_and_motor_angles_are_inverse():
    psi = np.random.default_rng(0).uniform(-20, 20, (100, 2))
    there = c_drive.motor_angles(c_drive.collar_pose(psi, P.lead), P.lead)
    np.testing.assert_allclose(there, psi, rtol=0, atol=1e-13)


def test_damping_matrix_is_eq_2_6b():
    d11, d12 = P.beta + P.gamma / 2, -P.gamma / 2
    np.testing.assert_allclose(c_drive.damping_matrix(P), [[d11, d12], [d12, d11]], atol=1e-18)


def test_inertia_from_physical_parameters_gives_kinetic_energy_of_the_parts():
    m, I_c, I_h = 4.0, 6e-3, 5e-4
    p = CDriveParameters.from_physical(collar_mass=m, collar_inertia=I_c, rotor_inertia=I_h)
    rate = np.array([3.0, -7.0])
    u_dot, theta_dot = c_drive.collar_pose(rate, p.lead)
    parts = 0.5 * (m * u_dot**2 + I_c * theta_dot**2 + I_h * rate @ rate)
    assert 0.5 * rate @ c_drive.inertia_matrix(p) @ rate == pytest.approx(parts, rel=1e-14)


def test_parameters_round_trip_through_yaml(tmp_path):
    p = CDriveParameters(beta=1e-3, eta=0.2)
    p.save(tmp_path / "p.yaml")
    assert CDriveParameters.load(tmp_path / "p.yaml") == p


@pytest.mark.parametrize(
    ("field", "value"), [("lead", 0.0), ("m12", 3e-3), ("beta", -1.0), ("delta", float("nan"))]
)
def test_impossible_parameters_are_refused_by_name(field, value):
    with pytest.raises(ValueError, match=field):
        CDriveParameters(**{field: value})


def test_unknown_key_in_a_parameter_file_is_named(tmp_path):
    (tmp_path / "p.yaml").write_text("betta: 1.0\n")
    with pytest.raises(ValueError, match="betta"):
        CDriveParameters.load(tmp_path / "p.yaml")
