"""Where a base is in MoveIt's files: joints of several degrees of freedom, and variables by name."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robot.test_moving_base import NAMES, SRDF, Made, cart, plane
from trajopt.files.moveit import read_request, read_scene
from trajopt.ros import commander
from trajopt.values.errors import FileFormatError

__all__ = ["cart"]
AT = (
    "multi_dof_joint_state: {header: {frame_id: odom}, joint_names: [odom_joint], "
    "transforms: [{translation: [1, 2, 0], rotation: [0, 0, 0.479425538604203, 0.8775825618903728]}]}"
)
"""x = 1 m, y = 2 m, yaw = 1 rad."""
BALL = "primitives: [{type: sphere, dimensions: [0.1]}]"

Write = Callable[[str], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def make(text: str) -> Path:
        (tmp_path / "file.yaml").write_text(text)
        return tmp_path / "file.yaml"

    return make


def test_a_base_is_where_the_state_has_it(cart: Made, write: Write) -> None:
    robot = cart(base=plane())
    text = f"robot_state: {{joint_state: {{name: [elbow], position: [0.3]}}, {AT}}}"
    file = read_scene(
        write(f"{text}\nworld: {{collision_objects: [{{id: a, header: {{frame_id: odom}}, {BALL}}}]}}"), robot
    )
    assert file.positions == pytest.approx([1.0, 2.0, 1.0, 0.0, 0.3]) and not file.notes
    assert file.scene.placement_of("a", file.positions).translation == pytest.approx([0, 0, 0])
    assert file.scene.placement_of("plate", file.positions).translation == pytest.approx([1, 2, 0])
    with pytest.raises(FileFormatError, match="raise or tilt"):
        read_scene(write(text.replace("[1, 2, 0]", "[1, 2, 0.3]")), robot)


def test_variables_are_constrained_by_name(cart: Made, write: Write) -> None:
    names = ("odom_joint/x", "odom_joint/y", "odom_joint/theta")
    goal = ", ".join(
        f"{{joint_name: {name}, position: {value}, tolerance_above: 0.01, tolerance_below: 0.01}}"
        for name, value in zip(names, (-0.5, 1.0, 7.0), strict=True)
    )
    text = f"{{group_name: base, start_state: {{{AT}}}, goal_constraints: [{{joint_constraints: [{goal}]}}]}}"
    request = read_request(write(text), to.Scene(cart(base=plane())))
    assert request.start[:3] == pytest.approx([1.0, 2.0, 1.0])
    (required,) = request.goals
    assert isinstance(required, type(to.joint_positions({"a": 0.0})))
    found = dict(required.positions)
    assert found == pytest.approx(dict(zip(names, (-0.5, 1.0, 7.0 - 2.0 * np.pi), strict=True))), (
        "nearest turn"
    )
    assert to.plan(request.problem()).verified


def test_a_fixed_base_takes_its_placement_from_the_state(cart: Made, write: Write) -> None:
    robot = cart()
    assert robot.joint_names == ("shoulder", "elbow")
    (note,) = (note for note in robot.notes if "planar joint" in note)
    assert "odom_joint" in note and "planar_base" in note
    balls = ", ".join(
        f"{{id: {name}, header: {{frame_id: {frame}}}, {BALL}}}"
        for name, frame in (("a", "odom"), ("b", "plate"))
    )
    objects = f"world: {{collision_objects: [{balls}]}}"
    file = read_scene(write(f"robot_state: {{{AT}}}\n{objects}"), robot)
    (note,) = file.notes
    assert "transforms[0]" in note and "is placed at (1, 2, 0) m" in note
    plate = file.scene.placement_of("plate", file.positions)
    assert plate.translation == pytest.approx([1, 2, 0]) and plate.rpy[2] == pytest.approx(1.0)
    ahead = np.array([1.0 + 0.9 * np.cos(1.0), 2.0 + 0.9 * np.sin(1.0), 0.4])
    assert file.scene.placement_of("tool", file.positions).translation == pytest.approx(ahead)
    assert file.scene.placement_of("a", file.positions).translation == pytest.approx([0, 0, 0])
    assert file.scene.placement_of("b", file.positions).translation == pytest.approx([1, 2, 0])
    assert to.Scene(robot).placement_of("plate", robot.positions()).translation == pytest.approx([0, 0, 0])

    joints = "{joint_name: elbow, position: 1.0}, {joint_name: shoulder, position: 0}"
    goal = f"goal_constraints: [{{joint_constraints: [{joints}]}}]"
    request = read_request(write(f"{{group_name: arm, {goal}}}"), file)
    assert request.problem().reduced.scene.placement_of("plate", request.start).translation[
        1
    ] == pytest.approx(2)
    elsewhere = AT.replace("[1, 2, 0]", "[3, 0, 0]")
    moved = read_request(write(f"{{group_name: arm, start_state: {{{elsewhere}}}, {goal}}}"), file)
    assert any("is placed at (3, 0, 0) m" in note for note in moved.notes)
    plan = to.plan(moved.problem()).require()
    end = plan.problem.reduced.all_positions(plan.trajectory.positions[-1])
    assert plan.problem.scene.placement_of("plate", end).translation == pytest.approx([3, 0, 0])
    run = to.simulate(plan)
    assert run.final_pose_error("tool").position < 0.01


def test_the_commander_moves_base_and_arm(cart: Made) -> None:
    """States and trajectories carry the base as MoveIt's do; turns that no message tells are kept."""
    robot = cart(base=plane())
    with commander.World(robot) as world:
        group = commander.MoveGroupCommander("all_of_it")
        for goal in (2.0, 4.0, 6.5):
            group.set_joint_value_target({NAMES[0]: 0.3 * goal, NAMES[2]: goal, "elbow": 0.4})
            success, message, _, _ = group.plan()
            assert success
            assert message.joint_trajectory.joint_names == ["shoulder", "elbow"]
            assert message.multi_dof_joint_trajectory.joint_names == ["odom_joint"]
            assert group.execute(message, wait=True)
            assert world.positions[[0, 2]] == pytest.approx([0.3 * goal, goal], abs=1e-2)
        state = group.get_current_state()
        assert state.joint_state.name == ["shoulder", "elbow"]
        assert state.multi_dof_joint_state.joint_names == ["odom_joint"]
        assert state.multi_dof_joint_state.header.frame_id == "odom"
        assert state.multi_dof_joint_state.transforms[0].translation.x == pytest.approx(0.3 * 6.5, abs=1e-2)
        group.set_start_state(state)
        group.set_joint_value_target({NAMES[0]: 0.0, NAMES[2]: 0.0})
        assert group.plan()[0]


def test_a_rail_has_one_number(cart: Made, write: Write) -> None:
    from trajopt.robot.bases import rail

    robot = cart(srdf=SRDF, base=rail((1, 0, 0), -1, 3, velocity=1, acceleration=1))
    assert robot.group("base").joints == ("odom_joint",)
    with pytest.raises(FileFormatError, match="odom_joint of cart cannot be elsewhere"):
        read_scene(write(f"robot_state: {{{AT}}}"), robot)


def test_the_workspace_holds_back_the_base(cart: Made, write: Write) -> None:
    """Around a post the shorter way is on the left; the workspace leaves the right one only."""
    scene = to.Scene(cart(base=plane())).add("post", to.Cylinder(0.3, 1.0), to.placement((1.0, -0.05, 0.5)))
    joints = ", ".join(
        f"{{joint_name: {name}, position: {value}}}"
        for name, value in zip(NAMES, (2.0, 0.0, 0.0), strict=True)
    )
    goal = f"goal_constraints: [{{joint_constraints: [{joints}]}}]"

    def sides(workspace: str, group: str = "base") -> tuple[int, set[bool]]:
        start = "start_state: {joint_state: {name: [shoulder, elbow], position: [2, 2]}}"
        text = f"{{group_name: {group}, {start}, {goal}, {workspace}}}"
        request = read_request(write(text), scene)
        y = to.plan(request.problem()).require().trajectory.positions[:, 1]
        return len(request.constraints), {bool(y.max() > 0.3), bool(y.min() < -0.3)}

    assert sides("")[0] == 0
    box = "workspace_parameters: {min_corner: [-1, -2, 0], max_corner: [3, 0.1, 0]}"
    assert sides(box) == (1, {False, True}) and sides(box.replace("0.1", "2").replace("-2", "-0.1"))[0] == 1
    assert sides("workspace_parameters: {min_corner: [0, 0, 0], max_corner: [0, 0, 0]}")[0] == 0
    bent = "goal_constraints: [{joint_constraints: [{joint_name: elbow, position: 1}]}]"
    arm = f"{{group_name: arm, {bent}, {box}}}"
    assert read_request(write(arm), scene).constraints == ()
    other = read_request(
        write(f"{{group_name: base, {goal}, {box[:-1]}, header: {{frame_id: plate}}}}}}"), scene
    )
    assert other.constraints == () and "of a frame that is not the world" in other.notes[0]
    with pytest.raises(FileFormatError, match="beyond its largest"):
        sides("workspace_parameters: {min_corner: [1, 0, 0], max_corner: [0, 1, 0]}")
