"""The MuJoCo model equals the Pinocchio model: kinematics, masses, limits, and colliding pairs."""

from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from tests.simulation.conftest import panda, reduced_all
from trajopt.robot.robot import Robot, configuration
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.simulation import build_spec
from trajopt.simulation.spec import describe, principal_inertia
from trajopt.values.placement import placement
from trajopt.values.shapes.shapes import Box, Sphere


def assert_same_dynamics(reduced: ReducedModel, *, count: int = 20) -> None:
    """Compare placements, mass matrix and bias forces at random states."""
    model = build_spec(reduced).compile()
    state = mujoco.MjData(model)
    data = reduced.model.createData()
    joints = [model.joint(name).id for name in tuple(reduced.model.names[1:])]
    position, velocity = model.jnt_qposadr[joints], model.jnt_dofadr[joints]
    rng = np.random.default_rng(7)
    for _ in range(count):
        p, v = rng.uniform(-3.0, 3.0, len(joints)), rng.normal(size=len(joints))
        state.qpos[position], state.qvel[velocity] = p, v
        mujoco.mj_forward(model, state)
        q = configuration(reduced.model, p)
        pin.forwardKinematics(reduced.model, data, q)
        for index, body in enumerate(model.jnt_bodyid[joints], start=1):
            assert np.allclose(state.xpos[body], data.oMi[index].translation, atol=1e-9)
            assert np.allclose(state.xmat[body].reshape(3, 3), data.oMi[index].rotation, atol=1e-9)
        mass = np.triu(pin.crba(reduced.model, data, q))
        mass += np.triu(mass, 1).T
        full = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, state, full)
        assert np.allclose(full[np.ix_(velocity, velocity)], mass, atol=1e-9)
        bias = pin.nonLinearEffects(reduced.model, data, q, v)
        assert np.allclose(state.qfrc_bias[velocity], bias, atol=1e-9)


def test_continuous_prismatic_odd_axes_and_mimic(odd: Robot) -> None:
    assert_same_dynamics(reduced_all(Scene(odd)))


def test_fixed_joints_stay_at_the_start(odd: Robot) -> None:
    start = odd.positions({"reach": 0.2, "elbow": 1.1})
    full = reduce_model(Scene(odd), "all", start)
    assert full.model.nv == 5
    assert_same_dynamics(full)


@pytest.mark.parametrize("group", ["panda_arm", "panda_arm_hand"])
def test_panda(group: str) -> None:
    robot = panda()
    assert_same_dynamics(reduce_model(Scene(robot), group, robot.positions("ready")), count=10)


def test_geometries_are_placed_at_the_bodies(odd: Robot) -> None:
    scene = Scene(odd).add("ball", Sphere(0.1), placement((0.3, 0.2, 0.9), rpy=(0.3, -0.8, 2.0)))
    scene = scene.add("part", Box(0.1, 0.02, 0.03), placement((0.02, 0.0, 0.1)), frame="tip")
    reduced = reduced_all(scene)
    model = build_spec(reduced).compile()
    state = mujoco.MjData(model)
    positions = np.array((0.4, 0.1, -0.7, 1.2))
    for row, name in enumerate(tuple(reduced.model.names[1:])):
        address = model.jnt_qposadr[model.joint(name).id]
        state.qpos[address] = (reduced.mimic_matrix @ positions + reduced.mimic_offset)[row]
    mujoco.mj_forward(model, state)
    place = reduced.all_positions(positions)
    for body in (*odd.bodies, *scene.object_bodies()):
        expected = scene.placement_of(body.frame, place) * body.placement
        found = state.geom(body.name)
        assert np.allclose(found.xpos, expected.translation, atol=1e-9), body.name
        assert np.allclose(found.xmat.reshape(3, 3), expected.rotation, atol=1e-9), body.name


def test_exactly_the_pairs_that_are_not_allowed_can_collide(odd: Robot) -> None:
    scene = Scene(odd).add("wall", Box(0.1, 1.0, 1.0), placement((0.9, 0.0, 0.5))).allow("wall", "tip")
    reduced = reduced_all(scene)
    model = build_spec(reduced).compile()
    expected = {
        frozenset((reduced.bodies[i].name, reduced.bodies[j].name))
        for i, j in zip(reduced.pairs.first, reduced.pairs.second, strict=True)
    }
    found = {
        frozenset((model.geom(a).name, model.geom(b).name))
        for a, b in zip(model.pair_geom1, model.pair_geom2, strict=True)
    }
    assert found == expected
    assert frozenset(("wall/0", "fore/0")) in found
    assert frozenset(("wall/0", "tip/0")) not in found
    assert not model.geom_contype.any() and not model.geom_conaffinity.any()


def test_limits_of_joints_and_motors(odd: Robot) -> None:
    model = build_spec(reduced_all(Scene(odd))).compile()
    assert not model.jnt_limited[model.joint("pan").id]
    assert np.allclose(model.joint("reach").range, (0.0, 0.3))
    assert np.allclose(model.joint("elbow").range, (-2.5, 2.5))
    assert [model.actuator(i).name for i in range(model.nu)] == ["pan", "reach", "elbow", "wrist"]
    assert np.allclose(model.actuator("reach").forcerange, (-90.0, 90.0))


def test_no_effort_limit_means_none(tmp_path: Path, odd: Robot) -> None:
    path = tmp_path / "free.urdf"
    path.write_text(odd.urdf_path.read_text().replace('effort="80"', 'effort="0"'))
    model = build_spec(reduced_all(Scene(Robot.from_urdf(path)))).compile()
    assert not model.actuator_forcelimited[model.actuator("pan").id]
    assert model.actuator_forcelimited[model.actuator("reach").id]


def test_possible_inertias_are_kept_to_the_last_digits() -> None:
    turned = pin.SE3.Random().rotation
    for moments in ((0.01, 0.02, 0.025), (0.01, 0.02, 0.03), (0.0, 0.02, 0.02)):
        matrix = turned @ np.diag(moments) @ turned.T
        found = principal_inertia(pin.Inertia(1.5, np.array((0.1, 0.2, 0.3)), matrix))
        axes = found.placement.rotation
        assert found.change == 0.0
        assert np.linalg.det(axes) > 0.0
        assert np.allclose(axes @ np.diag(found.moments) @ axes.T, matrix, atol=1e-13)


def test_impossible_inertia_is_corrected_to_the_nearest_with_a_note(tmp_path: Path, odd: Robot) -> None:
    path = tmp_path / "impossible.urdf"
    wrong = odd.urdf_path.read_text().replace(
        'ixx="0.02" iyy="0.02" izz="0.01"', 'ixx="0.02" iyy="0.01" izz="0.09"'
    )
    path.write_text(wrong)
    report = describe(reduced_all(Scene(Robot.from_urdf(path))))
    (note,) = report.notes
    assert note.startswith("turret: the stated inertia is impossible for a rigid body")
    inertia = report.spec.compile().body("turret").inertia
    assert np.allclose(sorted(inertia), (0.03, 0.04, 0.07), atol=1e-9)
