"""The continuous and the sampled plant of a drive."""

import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd
from pydrake.symbolic import Expression, Variable
from pydrake.systems.analysis import Simulator

from gapscope.models import c_drive, drive
from gapscope.models import c_drive_state_space as state_space
from gapscope.models.c_drive import CDriveParameters
from gapscope.systems import scalars
from gapscope.systems.drive_plant import DrivePlant, DrivePlant_
from gapscope.systems.sampled_drive_plant import SampledDrivePlant

P = CDriveParameters(delta=0.12, eta=0.05)
EPS = np.finfo(float).eps


def context_at(plant, state, torque):
    context = plant.CreateDefaultContext()
    context.SetContinuousState(state)
    plant.GetInputPort("torque").FixValue(context, torque)
    return context


def acceleration(plant, context):
    return plant.EvalTimeDerivatives(context).CopyToVector()[2:]


def friction_torque(rate):
    E = c_drive.ELEMENT_MAP
    dry = np.array([P.delta, P.delta, P.eta]) * np.tanh(E @ rate / P.sign_width)
    return c_drive.damping_matrix(P) @ rate + E.T @ dry


def test_ports_have_the_names_the_docs_give():
    for plant in (DrivePlant(c_drive.drive(P)), SampledDrivePlant(c_drive.drive(P), 1e-3)):
        assert [plant.get_input_port(i).get_name() for i in range(plant.num_input_ports())] == [
            "torque"
        ]
        names = [plant.get_output_port(i).get_name() for i in range(plant.num_output_ports())]
        assert names == ["position", "velocity", "state"]
        assert not plant.HasAnyDirectFeedthrough()


def test_power_balances_at_any_state():
    """d/dt (v M v / 2) = tau v - friction v, to the rounding of its terms."""
    plant, M = DrivePlant(c_drive.drive(P)), c_drive.inertia_matrix(P)
    rng = np.random.default_rng(3)
    for _ in range(20):
        q, v, torque = rng.normal(size=(3, 2)) * 5.0
        gain = v @ M @ acceleration(plant, context_at(plant, [*q, *v], torque))
        terms = torque @ v, -friction_torque(v) @ v
        assert gain == pytest.approx(sum(terms), abs=100 * EPS * np.abs(terms).max())


def test_coasting_loses_exactly_the_energy_that_friction_takes():
    """Energy and dissipated work over 0.2 s, both from one run; quadrature by Simpson's rule."""
    plant, M = DrivePlant(c_drive.drive(P)), c_drive.inertia_matrix(P)
    simulator = Simulator(plant, context_at(plant, [0, 0, 30.0, -20.0], [0.0, 0.0]))
    simulator.get_mutable_integrator().set_target_accuracy(1e-10)
    simulator.get_mutable_integrator().set_maximum_step_size(1e-3)
    times = np.linspace(0.0, 0.2, 201)
    rates = []
    for t in times:
        simulator.AdvanceTo(t)
        rates.append(simulator.get_context().get_continuous_state_vector().CopyToVector()[2:])
    power = np.array([friction_torque(v) @ v for v in rates])
    energy = np.array([0.5 * v @ M @ v for v in rates])
    weights = np.ones(201)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    lost = weights @ power * (times[1] - times[0]) / 3.0
    assert np.all(np.diff(energy) < 0.0)
    assert energy[0] - energy[-1] == pytest.approx(lost, rel=1e-7)


def test_response_to_a_held_torque_is_the_analytic_one():
    linear = CDriveParameters()
    plant = DrivePlant(c_drive.drive(linear))
    simulator = Simulator(plant, context_at(plant, [0.1, 0.2, 1.0, -2.0], [0.3, -0.1]))
    simulator.get_mutable_integrator().set_target_accuracy(1e-10)
    simulator.get_mutable_integrator().set_maximum_step_size(1e-3)
    simulator.AdvanceTo(0.3)
    angle, rate = state_space.held_torque_response(
        linear, [0.1, 0.2], [1.0, -2.0], [0.3, -0.1], 0.3
    )
    x = simulator.get_context().get_continuous_state_vector().CopyToVector()
    np.testing.assert_allclose(x, [*angle, *rate], rtol=1e-9)


@pytest.mark.parametrize(
    ("index", "row", "column"),
    [
        (DrivePlant.ELEMENT, 0, drive.VISCOUS),
        (DrivePlant.ELEMENT, 2, drive.FORWARD),
        (DrivePlant.ELEMENT, 1, drive.WIDTH),
        (DrivePlant.LOAD, 1, drive.BIAS),
        (DrivePlant.LOAD, 0, drive.RIPPLE_COS),
        (DrivePlant.INERTIA_INVERSE, 0, 1),
    ],
)
@pytest.mark.parametrize("parameters", [P, CDriveParameters()], ids=["dry", "viscous only"])
def test_derivative_by_a_context_parameter_is_the_finite_difference(parameters, index, row, column):
    """Also where the constant is zero and the float law skips its effect."""
    plant = DrivePlant(c_drive.drive(parameters))
    state, torque = [0.4, -0.3, 0.7, -0.5], [0.2, 0.1]
    entry = row * SHAPES[index] + column

    dual = plant.ToAutoDiffXd()
    context = dual.CreateDefaultContext()
    context.SetContinuousState([AutoDiffXd(x) for x in state])
    dual.GetInputPort("torque").FixValue(context, [AutoDiffXd(x) for x in torque])
    values = context.get_mutable_numeric_parameter(index)
    values.SetAtIndex(entry, AutoDiffXd(values[entry].value(), [1.0]))
    got = np.array([gradient(a) for a in acceleration(dual, context)])

    def shifted(step):
        context = context_at(plant, state, torque)
        values = context.get_mutable_numeric_parameter(index)
        values.SetAtIndex(entry, values[entry] + step)
        return acceleration(plant, context)

    step = 1e-5
    wanted = (shifted(step) - shifted(-step)) / (2 * step)
    scale = np.abs(wanted).max()
    if column == drive.WIDTH and parameters.delta == 0.0:
        assert scale == 0.0
    else:
        assert scale > 0.0
    np.testing.assert_allclose(got, wanted, rtol=0, atol=1e-7 * scale + 1e-6)


SHAPES = {DrivePlant.ELEMENT: 10, DrivePlant.LOAD: 5, DrivePlant.INERTIA_INVERSE: 2}


def gradient(value):
    derivatives = value.derivatives()
    return derivatives[0] if len(derivatives) else 0.0


def test_symbolic_plant_gives_the_equation_of_motion():
    plant = DrivePlant(c_drive.drive(P))
    symbolic = plant.ToSymbolic()
    names = [Variable(name) for name in ("q1", "q2", "v1", "v2", "u1", "u2", "beta")]
    context = symbolic.CreateDefaultContext()
    context.SetContinuousState([Expression(name) for name in names[:4]])
    symbolic.GetInputPort("torque").FixValue(context, [Expression(name) for name in names[4:6]])
    context.get_mutable_numeric_parameter(plant.ELEMENT).SetAtIndex(0, Expression(names[6]))
    values = dict(zip(names, [0.1, 0.2, 3.0, -1.0, 0.4, 0.3, P.beta]))
    got = [a.Evaluate(values) for a in acceleration(symbolic, context)]
    numeric = context_at(plant, [0.1, 0.2, 3.0, -1.0], [0.4, 0.3])
    np.testing.assert_allclose(got, acceleration(plant, numeric), rtol=1e-12)


def test_all_scalars_are_instantiated():
    for scalar in (float, AutoDiffXd, Expression):
        assert DrivePlant_[scalar](c_drive.drive(P)).num_continuous_states() == 4


def test_presliding_needs_the_sampled_plant():
    plant = c_drive.drive(P)
    plant.element[0, drive.STIFFNESS] = 100.0
    with pytest.raises(ValueError, match="Use SampledDrivePlant"):
        DrivePlant(plant)
    assert SampledDrivePlant(plant, 1e-3).num_output_ports() == 3


def test_contexts_share_no_constants():
    plant = SampledDrivePlant(c_drive.drive(P), 1e-3)
    first, second = plant.CreateDefaultContext(), plant.CreateDefaultContext()
    scalars.set_parameter(first, plant.INERTIA_INVERSE, np.eye(2))
    np.testing.assert_array_equal(plant.drive_of(first).inertia_inverse, np.eye(2))
    np.testing.assert_array_equal(
        plant.drive_of(second).inertia_inverse, c_drive.drive(P).inertia_inverse
    )


@pytest.mark.parametrize(("field", "value"), [("period", 0.0), ("substeps", 0)])
def test_impossible_sampling_is_refused_by_name(field, value):
    with pytest.raises(ValueError, match=field):
        SampledDrivePlant(c_drive.drive(P), **{"period": 1e-3, field: value})
