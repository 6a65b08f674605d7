"""Two arms: groups that move together in one proven motion, and a hand for each."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.driving import run
from trajopt.files.bundle import read_result
from trajopt.tasks import (
    AnyOrder,
    Dwell,
    MoveTo,
    PickObject,
    PlaceObject,
    SetGripper,
    Task,
    TaskResult,
    TaskStage,
    Together,
    read_task,
)
from trajopt.tasks.grasping import Place, grasps_of, gripper_of, pick_and_place
from trajopt.tasks.grasping.simulation import Hold
from trajopt.tasks.remaining import RemainingStages
from trajopt.values.errors import GripperError, ProblemError

LEFT, RIGHT = "left_panda_arm", "right_panda_arm"
TOOLS = {LEFT: "left_panda_hand_tcp", RIGHT: "right_panda_hand_tcp"}


@pytest.fixture(scope="module")
def arms() -> to.Scene:
    return to.Scene(to.load("two_pandas"))


WAYS = {"A": (LEFT, 0.1, 0.1, -0.1), "B": (LEFT, -0.1, 0.0, 0.1), "C": (RIGHT, 0.1, -0.1, 0.0)}
"""Name of a move -> its group, and the way of its tool from where it is at "ready" [m]."""


def moved(scene: to.Scene, group: str, name: str, *way: float) -> MoveTo:
    return MoveTo(there(scene, group, *way), group=group, name=name)


def there(scene: to.Scene, group: str, *way: float) -> to.Placement:
    ready = scene.placement_of(TOOLS[group], scene.robot.positions("ready"))
    return to.placement(ready.translation + np.array(way), rotation=ready.rotation)


def three(scene: to.Scene) -> tuple[MoveTo, MoveTo, MoveTo]:
    first, second, third = (moved(scene, group, name, *way) for name, (group, *way) in WAYS.items())
    return first, second, third


def task(scene: to.Scene, *stages: TaskStage) -> Task:
    return Task(scene=scene, group="both", start="ready", stages=stages)


@pytest.fixture(scope="module")
def both(arms: to.Scene) -> TaskResult:
    *left, right = three(arms)
    return to.plan(task(arms, MoveTo("ready", name="first"), Together([left, right]), MoveTo("ready")))


def test_each_group_has_its_own_begin_and_end_in_one_motion(both: TaskResult, arms: to.Scene) -> None:
    assert both.verified, both.explain()
    assert len(both.segments) <= 2, "they do not rest between"
    times = {stage.name: stage for stage in both.stages}
    assert times["A"].begin == times["C"].begin == times["first"].end
    assert times["B"].begin == times["A"].end
    assert times["move to ready"].begin == max(times["B"].end, times["C"].end)
    whole, trajectory = both.whole
    for name, (group, *way) in WAYS.items():
        at = whole.all_positions(trajectory(times[name].end))
        reached = arms.placement_of(TOOLS[group], at).translation
        np.testing.assert_allclose(reached, there(arms, group, *way).translation, atol=2e-3)


def test_together_is_faster_than_one_after_the_other(both: TaskResult, arms: to.Scene) -> None:
    alone = to.plan(task(arms, *three(arms), MoveTo("ready")))
    assert both.duration < 0.9 * alone.duration
    still = arms.robot.index(arms.robot.group(RIGHT).joints)
    until = alone.stages[0].end
    whole, trajectory = alone.whole
    rows = np.array([whole.all_positions(trajectory(time))[still] for time in np.linspace(0.0, until, 20)])
    assert np.ptp(rows, axis=0).max() < 0.2, "the other arm nearly rests"


def test_arms_that_cross_keep_clear_of_each_other(arms: to.Scene) -> None:
    across = moved(arms, LEFT, "over", 0.1, -0.25, 0.2), moved(arms, RIGHT, "under", 0.1, 0.25, -0.2)
    found = to.plan(task(arms, Together(across)))
    assert found.verified, found.explain()
    assert found.certificate.clearance > 0.0


def test_a_result_with_groups_is_read_as_it_was_written(both: TaskResult, tmp_path: Path) -> None:
    both.save(tmp_path / "both.trajopt")
    again = read_result(tmp_path / "both.trajopt")
    assert isinstance(again, TaskResult)
    assert again.stages == both.stages


def test_what_remains_of_groups_is_moved_together(arms: to.Scene) -> None:
    *left, right = three(arms)
    stage = task(arms, Together([left, right])).stages[0]
    ready = arms.robot.positions("ready")
    remaining = RemainingStages(
        scene=arms, group="both", done=["A"], ahead={"C": ready, "B": ready}, failed={}
    )
    (rest,) = remaining.of([stage])
    assert isinstance(rest, Together)
    assert [[move.name for move in item] for item in rest.items if isinstance(item, tuple)] == [["B"], ["C"]]


def test_groups_are_read_from_yaml(arms: to.Scene, tmp_path: Path) -> None:
    (tmp_path / "job.yaml").write_text(
        f"""
group: both
start: ready
stages:
  - together:
      - {{move_to: {{left_panda_joint1: 0.3}}, group: {LEFT}}}
      - [{{move_to: {{right_panda_joint1: 0.3}}, group: {RIGHT}, name: right}}]
"""
    )
    found = read_task(tmp_path / "job.yaml", arms)
    assert isinstance(found.stages[0], Together)
    assert to.plan(found).verified


@pytest.mark.parametrize(
    ("stage", "words"),
    [
        (lambda: Together([MoveTo("ready")]), "item 1: give every MoveTo the group that it moves"),
        (lambda: Together([Dwell(1.0)]), "item 1: groups that move together have MoveTo only"),
        (lambda: Together([[MoveTo({}, group=LEFT), Dwell(1.0)]]), "have MoveTo only"),
        (
            lambda: Together([MoveTo({"left_panda_joint1": 0.1}, group=LEFT)] * 2),
            "have joint 'left_panda_joint1' in common",
        ),
        (
            lambda: MoveTo({"left_panda_finger_joint1": 0.0}, group="left_hand"),
            "joints that the task does not move: left_panda_finger_joint1",
        ),
        (lambda: AnyOrder([MoveTo("ready", group=LEFT)]), "items in any order move the group of the task"),
    ],
)
def test_groups_that_cannot_move_together_are_refused(arms: to.Scene, stage: object, words: str) -> None:
    with pytest.raises(ProblemError, match=words):
        task(arms, stage())  # pyright: ignore[reportCallIssue, reportUnknownArgumentType]


@pytest.fixture(scope="module")
def parts(arms: to.Scene) -> to.Scene:
    arms = arms.add("table", to.Box(0.6, 1.2, 0.04), to.placement((0.5, 0.0, -0.02)))
    for name, y in (("cup", 0.3), ("can", -0.3)):
        arms = arms.add(name, to.Cylinder(0.03, 0.12), to.placement((0.5, y, 0.06)), mass=0.2)
    return arms


YAML = """
group: both
start: ready
stages:
  - {pick: cup, end_effector: left_hand}
  - {pick: can, end_effector: right_hand}
  - {place: cup, at: {position: [0.5, 0.15, 0.06]}}
  - {place: can, at: {position: [0.5, -0.15, 0.06]}}
"""


def test_each_hand_holds_its_own_object(parts: to.Scene, tmp_path: Path) -> None:
    (tmp_path / "job.yaml").write_text(YAML)
    job = read_task(tmp_path / "job.yaml", parts)
    found = to.plan(job)
    assert found.verified, found.explain()
    rollout = to.simulate(found)
    assert [each.hold for each in rollout.handlings] == [Hold.HELD, Hold.HELD], rollout.summary()
    with pytest.raises(ProblemError, match="'left_panda_hand_tcp', 'right_panda_hand_tcp', but only one"):
        run(job)


def test_the_hand_of_a_group_is_known(parts: to.Scene) -> None:
    robot = parts.robot
    for group, side in ((LEFT, "left"), ("right_panda_manipulator", "right")):
        assert gripper_of(robot, group=group).group == f"{side}_hand"
    with pytest.raises(GripperError, match="left_hand, right_hand: pass gripper=gripper_of"):
        gripper_of(robot, group="both")
    with pytest.raises(ProblemError, match=r"stage 'gripper'.*left_hand, right_hand"):
        task(parts, SetGripper(0.02))
    left = gripper_of(robot, end_effector="left_hand")
    place = Place(placement=to.placement((0.5, 0.15, 0.06)))
    grasps = grasps_of(parts, "cup", left)
    alone = pick_and_place(parts, "cup", start="ready", grasps=grasps, places=place, group=LEFT)
    assert alone.verified
    assert alone.gripper.group == "left_hand"
    picked = PickObject("cup", grasps, left)
    assert to.plan(task(parts, picked, PlaceObject("cup", place))).verified
