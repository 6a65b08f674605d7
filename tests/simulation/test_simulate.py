"""Rollouts against closed forms: holding, following, contacts, and weak motors."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.simulation.conftest import INERTIA, LENGTH, MASS, reduced_all, smooth
from trajopt.robot.bodies import MeshPolicy
from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.simulation import SimulationOptions, simulate
from trajopt.values.errors import ModelError, ShapeError
from trajopt.values.placement import placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Sphere, convex
from trajopt.values.trajectory import Trajectory

GRAVITY = 9.81
Pendulum = Callable[..., Robot]


def test_pendulum_holds_against_gravity(pendulum: Pendulum) -> None:
    reduced = reduced_all(Scene(pendulum()))
    angle = np.array([0.4])
    rollout = simulate(reduced, smooth(reduced, angle, angle, 0.5))
    expected = MASS * GRAVITY * LENGTH * np.cos(0.4)
    assert np.allclose(rollout.torques, expected, rtol=1e-6)
    assert rollout.tracking_error.maximum[0] < 1e-9
    assert rollout.final_pose_error().position < 1e-9
    assert not rollout.contacts and not rollout.saturated and rollout.diverged is None


def test_moving_pendulum_needs_the_torque_of_its_equation(pendulum: Pendulum) -> None:
    reduced = reduced_all(Scene(pendulum()))
    planned = smooth(reduced, np.array([-0.5]), np.array([1.0]), 1.0)
    rollout = simulate(reduced, planned)
    moment = INERTIA + MASS * LENGTH**2
    t = rollout.times
    gravity = MASS * GRAVITY * LENGTH * np.cos(planned(t)[:, 0])
    expected = gravity + moment * np.where(t <= 1.0, planned(t, 2)[:, 0], 0.0)
    # One control step of delay and first-order integration: a small share of the torque.
    assert np.abs(rollout.torques[:, 0] - expected).max() < 0.01 * np.abs(expected).max()
    assert rollout.tracking_error.maximum[0] < 1e-3
    assert rollout.tracking_error.rms[0] <= rollout.tracking_error.maximum[0]
    assert rollout.duration == pytest.approx(1.3)
    assert np.allclose(np.diff(t)[:-1], 0.01)


def test_smaller_steps_reduce_the_error(pendulum: Pendulum) -> None:
    reduced = reduced_all(Scene(pendulum()))
    planned = smooth(reduced, np.array([-0.5]), np.array([1.0]), 0.8)
    errors = [
        simulate(reduced, planned, options=SimulationOptions(dt=dt)).tracking_error.maximum[0]
        for dt in (0.004, 0.001)
    ]
    assert errors[1] < 0.4 * errors[0]


def test_weak_motor_is_reported_and_the_error_grows(pendulum: Pendulum) -> None:
    errors = []
    for effort in (100.0, 6.0):
        reduced = reduced_all(Scene(pendulum(effort=effort)))
        rollout = simulate(reduced, smooth(reduced, np.array([1.4]), np.array([0.2]), 0.8))
        errors.append(rollout.tracking_error.maximum[0])
        assert np.abs(rollout.torques).max() <= effort
    assert dict(rollout.saturated).keys() == {"swing"}
    assert 0.1 < rollout.saturated["swing"] <= rollout.duration + 1e-9
    assert errors[1] > 20.0 * errors[0]
    assert "motors at their limit: swing" in rollout.summary()


def test_motor_without_limit_is_never_saturated(pendulum: Pendulum) -> None:
    reduced = reduced_all(Scene(pendulum(effort=0.0)))
    assert np.isinf(reduced.limits.effort).all()
    rollout = simulate(reduced, smooth(reduced, np.array([-1.0]), np.array([1.0]), 0.2))
    assert not rollout.saturated
    assert rollout.tracking_error.maximum[0] < 0.02


def test_running_into_a_box_is_reported_with_time_and_pair(pendulum: Pendulum) -> None:
    # The tip, 0.5 m out and 5 cm thick, swings down from level onto a box below.
    scene = Scene(pendulum()).add("block", Box(0.4, 0.4, 0.2), placement((0.5, 0.0, 0.6)))
    reduced = reduced_all(scene)
    planned = smooth(reduced, np.array([0.0]), np.array([-0.8]), 1.0)
    rollout = simulate(reduced, planned)
    first = rollout.contacts[0]
    assert first.pair == ("block", "tip")
    assert rollout.collisions == rollout.contacts
    # Surfaces meet when the tip's centre is 5 cm above the box: 0.5 sin(angle) = 0.25.
    times = np.linspace(0.0, 1.0, 10001)
    expected = times[np.argmax(0.5 * np.sin(planned(times)[:, 0]) < -0.25)]
    assert first.start == pytest.approx(expected, abs=0.004)
    assert first.end > rollout.duration - 0.05
    assert 0.0 < first.depth < 0.05
    assert rollout.tracking_error.maximum[0] > 0.1
    assert rollout.final_pose_error().position > 0.05
    assert "block touches tip" in rollout.summary()


def test_allowed_pair_passes_through(pendulum: Pendulum) -> None:
    scene = Scene(pendulum()).add("block", Box(0.4, 0.4, 0.2), placement((0.5, 0.0, 0.6)))
    reduced = reduced_all(scene.allow("block"))
    rollout = simulate(reduced, smooth(reduced, np.array([0.0]), np.array([-0.8]), 1.0))
    assert not rollout.contacts
    assert rollout.tracking_error.maximum[0] < 1e-3


def test_allowed_contact_is_not_a_collision(pendulum: Pendulum) -> None:
    # The tip rests on the box, 1 mm deep, and is lifted off.
    scene = Scene(pendulum()).add("block", Box(0.4, 0.4, 0.2), placement((0.5, 0.0, 0.851)))
    meant = scene.allow_contact("lift-off", "tip", "block", depth=2e-3, first=0.5)
    motion = np.array([0.0]), np.array([0.5]), 1.0
    for given, collisions in ((meant, 0), (scene, 1)):
        reduced = reduced_all(given)
        rollout = simulate(reduced, smooth(reduced, *motion))
        (contact,) = rollout.contacts
        assert contact.start == 0.0 and contact.end < 0.5
        assert contact.depth == pytest.approx(1e-3, abs=3e-4)
        assert len(rollout.collisions) == collisions


def linkage(folder: Path, knee: float) -> Robot:
    """Return a palletizer's arm: two linkages keep the hand level, and a light link is between heavy ones.

    Without a mass of the knee, that link has no inertia.
    """

    def link(name: str, mass: float, reach: str) -> str:
        inertia = '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>'
        if mass == 0.0:
            return f'<link name="{name}"/>'
        return (
            f'<link name="{name}"><inertial><origin xyz="{reach}"/><mass value="{mass}"/>{inertia}'
            "</inertial></link>"
        )

    def joint(name: str, parent: str, child: str, at: str, follows: str = "") -> str:
        mimic = f'<mimic joint="{follows}" multiplier="-1"/>' if follows else ""
        return (
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{at}"/><axis xyz="0 1 0"/>'
            f'<limit lower="-1.6" upper="1.6" velocity="2" effort="3000"/>{mimic}</joint>'
        )

    parts = (
        '<link name="base"/>',
        joint("swing", "base", "boom", "0 0 1") + link("boom", 30.0, "0 0 0.4"),
        joint("upright", "boom", "knee", "0 0 0.8", "swing") + link("knee", knee, "0 0 0"),
        joint("reach", "knee", "forearm", "0 0 0") + link("forearm", 20.0, "0.4 0 0"),
        joint("level", "forearm", "hand", "0.8 0 0", "reach") + link("hand", 6.0, "0 0 0"),
    )
    (folder / "linkage.urdf").write_text(f'<robot name="linkage">{"".join(parts)}</robot>')
    return Robot.from_urdf(folder / "linkage.urdf")


@pytest.mark.parametrize("knee", [1.0, 0.0])
def test_heavy_links_coupled_by_a_light_one_follow(knee: float, tmp_path: Path) -> None:
    reduced = reduced_all(Scene(linkage(tmp_path, knee)))
    rollout = simulate(reduced, smooth(reduced, np.zeros(2), np.array([0.4, 0.3]), 1.0))
    assert rollout.diverged is None
    assert rollout.tracking_error.maximum.max() < 1e-3 and not rollout.saturated


def test_odd_arm_with_a_mimicking_joint_follows(odd: Robot) -> None:
    reduced = reduced_all(Scene(odd))
    start, end = np.array((0.0, 0.05, -0.5, 0.3)), np.array((4.0, 0.25, 0.6, -0.9))
    rollout = simulate(reduced, smooth(reduced, start, end, 3.0))
    assert not rollout.contacts and not rollout.saturated
    assert rollout.tracking_error.maximum.max() < 2e-3
    # The continuous joint counts on past half a turn.
    assert rollout.positions[-1, 0] == pytest.approx(4.0, abs=1e-4)
    error = rollout.final_pose_error("finger")
    assert error.position < 1e-4 and error.rotation < 1e-3


def test_joints_in_another_order_are_the_same_motion(odd: Robot) -> None:
    reduced = reduced_all(Scene(odd))
    start, end = np.array((0.0, 0.05, -0.5, 0.3)), np.array((0.5, 0.15, 0.2, -0.2))
    straight = smooth(reduced, start, end, 1.0)
    order = [2, 0, 3, 1]
    still = np.zeros((2, 4))
    shuffled = Trajectory(
        tuple(straight.joint_names[i] for i in order),
        straight.times,
        straight.positions[:, order],
        still,
        still,
    )
    one, other = simulate(reduced, straight), simulate(reduced, shuffled)
    assert other.joint_names == reduced.joint_names
    assert np.array_equal(one.positions, other.positions)


def test_attached_object_collides(pendulum: Pendulum) -> None:
    scene = Scene(pendulum()).add("ball", Sphere(0.05), placement((0.1, 0.0, 0.0)), frame="tip")
    scene = scene.add("block", Box(0.1, 0.4, 0.2), placement((0.55, 0.0, 0.6)))
    reduced = reduced_all(scene)
    rollout = simulate(reduced, smooth(reduced, np.array([0.3]), np.array([-0.5]), 1.0))
    assert ("ball", "block") in {contact.pair for contact in rollout.contacts}


def test_exact_mesh_collides_as_its_cover_with_a_note(pendulum: Pendulum) -> None:
    corners = np.array([(x, y, z) for x in (0.3, 0.7) for y in (-0.2, 0.2) for z in (0.5, 0.7)])
    block = convex(corners)
    mesh = Mesh(block.vertices, block.faces.astype(np.int32))
    scene = Scene(pendulum()).add("block", mesh, meshes=MeshPolicy(exact=True))
    reduced = reduced_all(scene)
    rollout = simulate(reduced, smooth(reduced, np.array([0.0]), np.array([-0.8]), 1.0))
    assert rollout.contacts[0].pair == ("block", "tip")
    (note,) = rollout.notes
    assert note.startswith("block/0: the exact mesh is simulated by a cover that contains it")


def test_rollout_fits_into_json(pendulum: Pendulum) -> None:
    scene = Scene(pendulum(effort=5.0)).add("block", Box(0.4, 0.4, 0.2), placement((0.5, 0.0, 0.6)))
    reduced = reduced_all(scene)
    rollout = simulate(reduced, smooth(reduced, np.array([0.0]), np.array([-0.8]), 0.4))
    document = json.loads(json.dumps(rollout.as_dict(), allow_nan=False))
    assert document["joint_names"] == ["swing"]
    assert np.array(document["positions"]).shape == rollout.positions.shape
    assert document["contacts"][0]["pair"] == ["block", "tip"]
    assert document["final_pose_error"]["frame"] == "tip"


def test_diverged_simulation_reports_its_time(pendulum: Pendulum) -> None:
    reduced = reduced_all(Scene(pendulum(effort=0.0)))
    jump = Trajectory(reduced.joint_names, np.array([0.0, 0.1]), np.array([[0.0], [3e4]]))
    rollout = simulate(reduced, jump)
    assert rollout.diverged == pytest.approx(0.002)
    assert np.isfinite(rollout.positions).all()
    assert "diverged" in rollout.summary()
    json.dumps(rollout.as_dict(), allow_nan=False)


def test_trajectory_of_other_joints_is_refused(pendulum: Pendulum) -> None:
    reduced = reduced_all(Scene(pendulum()))
    other = Trajectory(("elsewhere",), np.array([0.0, 1.0]), np.zeros((2, 1)))
    with pytest.raises(ModelError, match="the trajectory moves elsewhere"):
        simulate(reduced, other)


@pytest.mark.parametrize(
    "wrong",
    [{"dt": 0.0}, {"dt": float("nan")}, {"settling_time": -1.0}, {"natural_frequency": 1000.0}],
    ids=str,
)
def test_options_are_checked(wrong: dict[str, float]) -> None:
    with pytest.raises(ShapeError, match=next(iter(wrong))):
        SimulationOptions(**wrong)


def test_nothing_is_written_to_disk(
    pendulum: Pendulum, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    reduced = reduced_all(Scene(pendulum(effort=0.0)))
    empty = tmp_path / "empty"
    empty.mkdir()
    monkeypatch.chdir(empty)
    jump = Trajectory(reduced.joint_names, np.array([0.0, 0.1]), np.array([[0.0], [3e4]]))
    simulate(reduced, jump)
    assert list(empty.iterdir()) == []
