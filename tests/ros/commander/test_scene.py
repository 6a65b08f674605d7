"""The scene through MoveIt's interface: the very next plan sees every edit."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from trajopt.ros.commander.moveit_msgs.msg import (
    AttachedCollisionObject,
    CollisionObject,
    LinkPadding,
    LinkScale,
    MoveItErrorCodes,
    PlanningScene,
    PlanningSceneComponents,
    PlanningSceneWorld,
)

import trajopt as to
from tests.robot.test_robot import tetrahedron
from trajopt import placement
from trajopt.ros.commander import MoveGroupCommander, MoveItCommanderException, PlanningSceneInterface, World
from trajopt.ros.commander.conversions import placement_of, stamped
from trajopt.values.shapes.shapes import bounding_box

AT = stamped(placement((0.3, 0.7, 0.1), rpy=(0, 0, 0.4)), "base")
EVERYTHING = 1023


@pytest.fixture
def scene(jumping: World) -> PlanningSceneInterface:
    return PlanningSceneInterface(world=jumping)


def test_the_next_plan_sees_an_edit(scene: PlanningSceneInterface, jumping: World) -> None:
    arm = MoveGroupCommander("arm")
    arm.set_named_target("straight")
    assert arm.plan()[0]
    scene.add_box("wall", stamped(placement((0.35, -0.05, 0.1)), "base"), (0.1, 0.1, 0.1))
    code = arm.plan()[3]
    assert code.val == MoveItErrorCodes.GOAL_IN_COLLISION
    assert "wall" in code.message
    scene.remove_world_object("wall")
    assert arm.plan()[0]


@pytest.mark.parametrize(
    ("add", "shape"),
    [
        (lambda scene: scene.add_box("it", AT, (0.1, 0.2, 0.3)), to.Box(0.1, 0.2, 0.3)),
        (lambda scene: scene.add_sphere("it", AT, 0.1), to.Sphere(0.1)),
        (lambda scene: scene.add_cylinder("it", AT, 0.3, 0.1), to.Cylinder(radius=0.1, length=0.3)),
        (lambda scene: scene.add_cone("it", AT, 0.3, 0.1), to.Cone(radius=0.1, length=0.3)),
        (lambda scene: scene.add_plane("it", AT), to.Plane()),
    ],
    ids=["box", "sphere", "cylinder", "cone", "plane"],
)
def test_shapes(
    scene: PlanningSceneInterface, jumping: World, add: Callable[..., None], shape: object
) -> None:
    add(scene)
    ((made, where),) = jumping.scene.object("it").parts
    assert made == shape
    placed = jumping.scene.holder("it").placement * where
    assert np.allclose(placed.homogeneous, placement_of(AT.pose).homogeneous)
    (told,) = scene.get_objects(["it"]).values()
    scene.clear()
    scene.add_object(told)
    ((again, where),) = jumping.scene.object("it").parts
    assert again == shape
    assert np.allclose((jumping.scene.holder("it").placement * where).homogeneous, placed.homogeneous)


def test_mesh(scene: PlanningSceneInterface, jumping: World, tmp_path: Path) -> None:
    (tmp_path / "wedge.stl").write_text(tetrahedron())
    scene.add_mesh("it", AT, str(tmp_path / "wedge.stl"), (0.1, 0.1, 0.1))
    (told,) = scene.get_objects(["it"]).values()
    assert len(told.meshes[0].triangles) == 4
    with pytest.raises(MoveItCommanderException, match="no such file"):
        scene.add_mesh("other", AT, "nowhere.stl")


def test_where_things_are(scene: PlanningSceneInterface) -> None:
    scene.add_box("near", stamped(placement((0.0, 0.6, 0.1)), ""), (0.1,) * 3)
    scene.add_sphere("far", stamped(placement((0.0, 3.0, 0.1)), "base"), 0.1)
    assert scene.get_known_object_names() == ["near", "far"]
    assert scene.get_known_object_names(with_type=True) == []
    assert scene.get_known_object_names_in_roi(-1, -1, -1, 1, 1, 1) == ["near"]
    assert scene.get_object_poses(["far"])["far"].position.y == pytest.approx(3.0)
    assert list(scene.get_object_poses(["fra", "near"])) == ["near"], "as in MoveIt: what there is"


def test_asking_whether_something_is_there(scene: PlanningSceneInterface) -> None:
    """As in MoveIt: scripts wait in a loop until what they ask for is there, or gone."""
    scene.add_box("near", stamped(placement((0.0, 0.6, 0.1)), ""), (0.1,) * 3)
    assert scene.get_attached_objects(["near"]) == {}
    assert scene.get_attached_objects([""]) == {}
    assert list(scene.get_objects(["far", "near"])) == ["near"]
    assert list(scene.get_objects()) == ["near"]


def test_operations(scene: PlanningSceneInterface, jumping: World) -> None:
    scene.add_box("it", AT, (0.1,) * 3)
    moved = CollisionObject(id="it", operation=CollisionObject.MOVE)
    moved.pose = stamped(placement((0, 0.5, 0.5)), "").pose
    scene.add_object(moved)
    assert np.allclose(jumping.scene.holder("it").placement.translation, (0, 0.5, 0.5))
    scene.remove_world_object()
    assert scene.get_known_object_names() == []


@pytest.mark.parametrize(
    "attach",
    [
        lambda scene, at: scene.attach_box("hand", "it", at, (0.05,) * 3, ["finger"]),
        lambda scene, at: scene.attach_sphere("hand", "it", at, 0.03, ["finger"]),
        lambda scene, at: scene.attach_cylinder("hand", "it", at, 0.05, 0.03, ["finger"]),
        lambda scene, at: scene.attach_object(scene.make_box("it", at, (0.05,) * 3), "hand", ["finger"]),
        lambda scene, at: scene.attach_object(
            AttachedCollisionObject("hand", scene.make_box("it", at, (0.05,) * 3)), touch_links=["finger"]
        ),
        lambda scene, at: (
            scene.add_box("it", at, (0.05,) * 3),
            scene.attach_box("hand", "it", touch_links=["finger"]),
        ),
    ],
    ids=["box", "sphere", "cylinder", "message", "attached message", "existing"],
)
def test_attaching(scene: PlanningSceneInterface, jumping: World, attach: Callable[..., None]) -> None:
    attach(scene, stamped(placement((0.15, 0.0, 0.0)), "hand"))
    item = jumping.scene.object("it")
    assert item.frame == "hand"
    assert item.touch_links == {"hand", "finger"}
    assert np.allclose(item.placement.translation, (0.15, 0, 0))
    assert list(scene.get_attached_objects()) == ["it"]
    assert scene.get_known_object_names() == []
    before = jumping.scene.placement_of("it", jumping.positions)
    with pytest.raises(MoveItCommanderException, match="no object in the world named 'it'"):
        scene.remove_world_object("it")
    with pytest.raises(MoveItCommanderException, match=r"no object in the world .*named 'it'"):
        scene.add_object(CollisionObject(id="it", operation=CollisionObject.MOVE))
    scene.add_object(CollisionObject(id="it", operation=CollisionObject.REMOVE))
    assert list(scene.get_attached_objects()) == ["it"]
    scene.remove_attached_object("hand", "it")
    assert scene.get_known_object_names() == ["it"]
    after = jumping.scene.placement_of("it", jumping.positions)
    assert np.allclose(before.homogeneous, after.homogeneous)


def test_planning_scenes_go_back_and_forth(scene: PlanningSceneInterface, jumping: World) -> None:
    scene.add_box("box", AT, (0.1, 0.2, 0.3))
    scene.attach_sphere("hand", "ball", stamped(placement((0.15, 0, 0)), "hand"), 0.03, ["finger"])
    whole = scene.get_planning_scene(EVERYTHING)
    whole.allowed_collision_matrix.set_allowed("box", "hand")
    assert whole.robot_state.joint_state.name == ["shoulder", "elbow", "wrist"]
    scene.clear()
    assert jumping.scene.objects == {}
    assert scene.apply_planning_scene(whole)
    assert scene.get_known_object_names() == ["box"]
    assert list(scene.get_attached_objects()) == ["ball"]
    assert jumping.scene.may_touch("box", "hand")
    assert not jumping.scene.may_touch("box", "fore")
    assert jumping.scene.may_touch("base", "upper")


def test_a_part_of_a_scene(scene: PlanningSceneInterface) -> None:
    scene.add_box("box", AT, (0.1, 0.2, 0.3))
    names = scene.get_planning_scene(PlanningSceneComponents.WORLD_OBJECT_NAMES)
    assert [(item.id, item.primitives) for item in names.world.collision_objects] == [("box", [])]
    assert names.robot_state.joint_state.name == []
    assert names.allowed_collision_matrix.entry_names == []


def test_differences(scene: PlanningSceneInterface, jumping: World) -> None:
    scene.add_box("box", AT, (0.1, 0.2, 0.3))
    ball = scene.make_sphere("ball", AT, 0.1)
    padding = [LinkPadding("hand", 0.05)]
    scene.apply_planning_scene(
        PlanningScene(is_diff=True, world=PlanningSceneWorld([ball]), link_padding=padding)
    )
    assert scene.get_known_object_names() == ["box", "ball"]
    assert jumping.scene.clearance_of("hand", "ball") == 0.05
    scene.add_sphere("later", AT, 0.1)
    assert jumping.scene.clearance_of("hand", "later") == 0.05
    for scale in (1.5, 1.2):  # the size is that of the last message, not of all together
        scene.apply_planning_scene(PlanningScene(is_diff=True, link_scale=[LinkScale("hand", scale)]))
    told = scene.get_planning_scene(PlanningSceneComponents.LINK_PADDING_AND_SCALING)
    assert told.link_padding == padding and told.link_scale == [LinkScale("hand", 1.2)]
    first = [bounding_box(body.shape) for body in jumping.robot.bodies if body.owner == "hand"]
    sizes = [bounding_box(body.shape) for body in jumping.scene.robot.bodies if body.owner == "hand"]
    assert np.allclose(sizes, 1.2 * np.array(first), atol=1e-12) and sizes
    scene.apply_planning_scene(PlanningScene(world=PlanningSceneWorld([ball])))
    assert scene.get_known_object_names() == ["ball"]
    assert jumping.scene.clearance_of("hand", "ball") == 0.0
    assert all(body.scale == 1.0 for body in jumping.scene.robot.bodies)


@pytest.mark.parametrize(
    ("misuse", "said"),
    [
        (
            lambda scene: scene.remove_world_object("bxo"),
            r"no object in the world named 'bxo' \(did you mean 'box'\?\); there are: box",
        ),
        (lambda scene: scene.remove_attached_object(name="bxo"), "no object named 'bxo'"),
        (lambda scene: scene.attach_object("bxo", "hand"), "no object named 'bxo'"),
        (lambda scene: scene.attach_box("hnad", "box"), r"did you mean 'hand'\?"),
        (lambda scene: scene.attach_box("hand", "box", touch_links=["fingre"]), r"did you mean 'finger'\?"),
        (lambda scene: scene.add_box("b", stamped(placement(), "tabel"), (1, 1, 1)), "no frame.*'tabel'"),
        (lambda scene: scene.add_box("b", AT, (1, 1)), r"a box has \[x, y, z\], not 2 numbers"),
        (lambda scene: scene.add_box("b", AT, (1, 1, -1)), "must be positive"),
        (lambda scene: scene.add_box("hand", AT, (1, 1, 1)), "taken by a frame of the robot"),
        (lambda scene: scene.add_object(None), "has no shape"),
        (
            lambda scene: scene.apply_planning_scene(PlanningScene(link_padding=[LinkPadding("hand", -1)])),
            "negative",
        ),
    ],
)
def test_misuse_changes_nothing(
    scene: PlanningSceneInterface, jumping: World, misuse: Callable[..., None], said: str
) -> None:
    scene.add_box("box", AT, (0.1, 0.1, 0.1))
    before = jumping.scene
    with pytest.raises(MoveItCommanderException, match=said):
        misuse(scene)
    assert jumping.scene is before
