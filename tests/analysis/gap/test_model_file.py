"""Log sets with a model file: what is refused, and a robot of one's own from log to cause."""

import numpy as np
import pytest
import yaml

from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.fitting import fit
from gapscope.analysis.gap.hypothesis import Hypothesis
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.gap.machines.model_file import load_arm
from gapscope.analysis.gap.prediction import Predictor
from gapscope.analysis.gap.rigid_machine import StateColumns


def urdf(base="world"):
    inertial = (
        '<inertial><origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx="0.01" iyy="0.01" '
        'izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    fixed = '<joint name="fix" type="fixed"><parent link="world"/><child link="base"/></joint>'
    return (
        f'<robot name="arm"><link name="base">{inertial}</link>{fixed if base == "world" else ""}'
        f'<link name="arm">{inertial}</link><joint name="shoulder" type="revolute">'
        '<parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>'
        '<limit lower="-3" upper="3" effort="9" velocity="9"/></joint></robot>'
    )


def folder_of(path, text=None, **system):
    (path / "arm.urdf").write_text(text or urdf())
    t = np.arange(500) * 0.002
    q = 0.5 * np.sin(6.0 * t)
    table = np.column_stack([t, q, np.cos(q)])
    np.savetxt(
        path / "run.csv", table, delimiter=",", header="t,shoulder,shoulder_tau", comments=""
    )
    document = {
        "format": 1,
        "system": {"model": "arm.urdf", "joints": ["shoulder"], **system},
        "controller": {"kind": "unknown"},
        "sample_time_s": 0.002,
        "columns": {"t": "s", "JOINT": "rad", "JOINT_tau": "N m"},
        "runs": [{"file": "run.csv", "use": "fit"}],
    }
    (path / "logset.yaml").write_text(yaml.safe_dump(document))
    return path


@pytest.mark.parametrize(
    ("system", "model", "message"),
    [
        ({"model": "none.urdf"}, None, "is no model file"),
        ({"joints": ["elbow"]}, None, "elbow"),
        ({}, urdf("floating"), "floats"),
        ({"modle": 1}, None, "modle"),
        ({"payload": {"body": "hand"}}, None, "hand"),
        ({}, "<robot", "Drake cannot read"),
    ],
)
def test_a_model_that_cannot_be_used_is_refused_with_one_message(tmp_path, system, model, message):
    with pytest.raises(InputError, match=message):
        read_machine(load_logset(folder_of(tmp_path, model, **system)))


def test_a_floating_base_may_be_welded(tmp_path):
    log = load_logset(folder_of(tmp_path, urdf("floating"), base="base"))
    machine, runs = read_machine(log)
    assert machine.joints == ("shoulder",)
    assert {p.name for p in machine.own} == {"mass_factor_base", "mass_factor_arm"}
    assert np.all(np.isfinite(machine.predict(runs[0], machine.build(machine.nominal()))))


def test_columns_near_the_measured_state_are_right_to_first_order(tmp_path):
    arm = load_arm(load_logset(folder_of(tmp_path)))
    t = np.linspace(0.0, 2.0, 200)[:, None]
    q, v = 0.8 * np.sin(3.0 * t), 2.4 * np.cos(3.0 * t)
    equation = StateColumns(arm.columns, q, v)
    dq, dv = np.full_like(q, 0.01), 0.01 * v
    for near, exact, at in zip(
        equation.near(dq, dv),
        arm.columns(q + dq, v + dv),
        (equation.mass, equation.bias, equation.load),
    ):
        assert np.max(np.abs(near - exact)) < 0.02 * max(np.max(np.abs(exact - at)), 1e-9)


def test_the_data_decide_how_sharp_dry_friction_is(tmp_path):
    """With a fixed width dry friction is better imitated by viscous friction with a peak at standstill."""
    level, share = 0.2, 0.15
    folder = folder_of(tmp_path)
    t = np.arange(1500) * 0.002
    q, v, a = 0.5 * np.sin(6.0 * t), 3.0 * np.cos(6.0 * t), -18.0 * np.sin(6.0 * t)
    friction = level * np.tanh(v / (share * np.sqrt(np.mean(v**2))))
    torque = 0.02 * a - 0.1 * 9.81 * np.cos(q) + friction  # of the arm in ``urdf``
    table = np.column_stack([t, q, torque])
    np.savetxt(
        folder / "run.csv", table, delimiter=",", header="t,shoulder,shoulder_tau", comments=""
    )
    machine, runs = read_machine(load_logset(folder))
    predictor = Predictor(machine, runs)
    retuned = fit(predictor, Hypothesis())
    (form,) = (f for f in machine.forms(runs) if f.effect == "friction.coulomb")
    found = fit(predictor, Hypothesis(forms=(form,)), retuned)
    values = found.by_key()
    assert values["friction.coulomb", "level_shoulder"] == pytest.approx(level, rel=0.02)
    # Speeds are smoothed, which blurs the sign by a tenth; the nominal width is a seventh of this one.
    assert values["friction.coulomb", "width_share"] == pytest.approx(share, rel=0.15)
    assert found.rms < 0.2 * retuned.rms
