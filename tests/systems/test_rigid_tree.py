"""The compiled tree of rigid bodies, and the rotary pendulum's closed form, against MultibodyPlant."""

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

from gapscope.models import furuta, rigid_tree_kernels
from gapscope.systems.rigid_tree import tree_of

GRAVITY = np.array([0.0, 0.0, -9.81])
SKEW = "<ixx>0.03</ixx><iyy>0.04</iyy><izz>0.05</izz><ixy>0.002</ixy><ixz>0</ixz><iyz>0.001</iyz>"


def link(name, joint, pose):
    inertial = f"<pose>0.1 0.05 0 0.3 0 0.1</pose><mass>1.3</mass><inertia>{SKEW}</inertia>"
    return f'<link name="{name}"><pose relative_to="{joint}">{pose}</pose><inertial>{inertial}</inertial></link>'


def joint(name, kind, parent, child, axis):
    pose = "0.3 -0.1 0.2 0.5 0.1 -0.7"
    return (
        f'<joint name="{name}" type="{kind}"><pose relative_to="{parent}">{pose}</pose>'
        f"<parent>{parent}</parent><child>{child}</child><axis><xyz>{axis}</xyz></axis></joint>"
    )


ARM = (
    '<sdf version="1.9"><model name="arm"><link name="base"/>'
    '<joint name="mount" type="fixed"><parent>world</parent><child>base</child></joint>'
    + link("first", "turn", "0.1 0.02 0.03 0.1 0.2 0.3")
    + joint("turn", "revolute", "base", "first", "0 0.6 0.8")
    + link("second", "slide", "0 0 0 0 0 0")
    + joint("slide", "prismatic", "first", "second", "0 1 0")
    + link("third", "roll", "0 0.1 0 0 0 0.4")
    + joint("roll", "revolute", "second", "third", "1 0 0")
    + "</model></sdf>"
)


def plant_of(sdf):
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(sdf, "sdf")
    plant.Finalize()
    return plant


def efforts(plant, q, v, a):
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    plant.SetVelocities(context, v)
    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)
    return plant.CalcInverseDynamics(context, a, forces)


def test_the_regressor_gives_the_efforts_of_the_plant_for_skew_axes_slides_and_offset_frames():
    plant = plant_of(ARM)
    tree, _, inertia = tree_of(plant, ["turn", "slide", "roll"], {})
    Y = np.empty((3, inertia.size))
    rng = np.random.default_rng(0)
    for q, v, a in rng.normal(size=(20, 3, 3)):
        rigid_tree_kernels.regressor(tree, q, v, a, GRAVITY, Y)
        np.testing.assert_allclose(Y @ inertia.ravel(), efforts(plant, q, v, a), atol=1e-12)


def test_the_columns_add_up_to_the_equation_of_motion():
    plant = plant_of(ARM)
    tree, _, inertia = tree_of(plant, ["turn", "slide", "roll"], {})
    q, v, a = np.random.default_rng(1).normal(size=(3, 5, 3))
    mass, bias, load = np.empty((5, 1, 3, 3)), np.empty((5, 1, 3)), np.empty((5, 1, 3))
    whole = inertia.reshape(-1, 1)
    rigid_tree_kernels.equation_columns(tree, whole, GRAVITY, q, v, mass, bias, load)
    for k in range(5):
        zero = np.zeros(3)
        expected = efforts(plant, q[k], v[k], a[k])
        np.testing.assert_allclose(mass[k, 0] @ a[k] + bias[k, 0], expected, atol=1e-12)
        np.testing.assert_allclose(load[k, 0], efforts(plant, q[k], zero, zero), atol=1e-12)


def test_a_locked_joint_is_part_of_its_parent():
    plant = plant_of(ARM)
    tree, _, inertia = tree_of(plant, ["turn", "roll"], {"slide": 0.2})
    q, v, a = np.random.default_rng(2).normal(size=(3, 2))
    Y = np.empty((2, inertia.size))
    rigid_tree_kernels.regressor(tree, q, v, a, GRAVITY, Y)
    full = [np.insert(x, 1, fixed) for x, fixed in ((q, 0.2), (v, 0.0), (a, 0.0))]
    np.testing.assert_allclose(Y @ inertia.ravel(), efforts(plant, *full)[[0, 2]], atol=1e-12)


def test_a_joint_that_is_neither_logged_nor_locked_is_named():
    with pytest.raises(ValueError, match="'slide' moves but is neither"):
        tree_of(plant_of(ARM), ["turn", "roll"], {})


def test_the_rotary_pendulum_moves_as_the_plant_does():
    p = furuta.FurutaParameters()
    half = 0.5 * p.L_p
    arm, com = p.J_r + p.J_m, p.J_p
    # The arm turns about z with the pendulum's axis along its length, upright at zero.
    sdf = f"""<sdf version="1.9"><model name="furuta">
    <link name="arm"><inertial><mass>1e-9</mass><inertia>
      <ixx>{arm}</ixx><iyy>{arm}</iyy><izz>{arm}</izz></inertia></inertial></link>
    <joint name="theta" type="revolute"><parent>world</parent><child>arm</child>
      <axis><xyz>0 0 1</xyz></axis></joint>
    <link name="pendulum"><pose relative_to="alpha"/><inertial><pose>0 0 {half} 0 0 0</pose>
      <mass>{p.m}</mass><inertia><ixx>{com}</ixx><iyy>{com}</iyy><izz>{1e-6 * com}</izz></inertia>
      </inertial></link>
    <joint name="alpha" type="revolute"><pose relative_to="arm">{p.L_r} 0 0 0 0 0</pose>
      <parent>arm</parent><child>pendulum</child><axis><xyz>-1 0 0</xyz></axis></joint>
    </model></sdf>"""
    plant = plant_of(sdf)
    J, P, C, G = p.groups
    for q, v, a in np.random.default_rng(3).normal(size=(10, 3, 2)):
        m11, m12, m22 = furuta.mass_matrix(q[1], J, P, C)
        h = furuta.bias(q[1], v[0], v[1], P, C, G)
        mine = np.array([[m11, m12], [m12, m22]]) @ a + h
        # The rod's own axis has a millionth of its inertia, for Drake's sake.
        np.testing.assert_allclose(mine, efforts(plant, q, v, a), rtol=1e-5, atol=1e-8)
