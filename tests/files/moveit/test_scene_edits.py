"""Planning scene messages: a scene becomes one and comes back, and differences change what is there."""

import json
from typing import Any

import numpy as np
import pytest

import trajopt as to
from trajopt.files.messages import (
    AttachedCollisionObject,
    CollisionObject,
    Generation,
    Header,
    JointState,
    PlanningScene,
    PlanningSceneComponents,
    Point,
    Pose,
    RobotState,
    SolidPrimitive,
    decode,
    document_of,
    encode,
)
from trajopt.files.moveit.frames import Reading, world_names
from trajopt.files.moveit.planning_scene import edit_scene
from trajopt.files.moveit.scene_messages import scene_message
from trajopt.values.errors import FileFormatError, FrameNotFound
from trajopt.values.shapes.mesh import Mesh

ALL = sum(
    value
    for name, value in vars(PlanningSceneComponents).items()
    if name.isupper() and isinstance(value, int)
)
SPHERE = [SolidPrimitive(SolidPrimitive.SPHERE, [0.05])]


def edited(scene: to.Scene, message: PlanningScene) -> to.Scene:
    robot = scene.robot
    reading = Reading(world_names(robot), robot.positions({}))
    return edit_scene(document_of(message, "scene"), scene, reading)


def difference(
    *objects: CollisionObject, attached: tuple[AttachedCollisionObject, ...] = ()
) -> PlanningScene:
    message = PlanningScene(is_diff=True, robot_state=RobotState(is_diff=True))
    message.world.collision_objects = list(objects)
    message.robot_state.attached_collision_objects = list(attached)
    return message


def leaves(document: object) -> list[object]:
    """Return the values of a document in their order, numbers for comparing."""
    match document:
        case dict():
            return [leaf for key, inner in document.items() for leaf in (key, *leaves(inner))]
        case list():
            return [len(document), *(leaf for inner in document for leaf in leaves(inner))]
        case float():
            return [pytest.approx(document, abs=1e-12)]
        case _:
            return [document]


def at(x: float) -> Pose:
    return Pose(Point(x, 0.0, 0.0))


@pytest.fixture
def full(planar_arm: to.Robot) -> to.Scene:
    """Every shape, something in the hand, a frame in the world and one on an object."""
    corners = to.Box(0.1, 0.2, 0.3)
    corners_of_wedge = np.array(((0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)), dtype=np.float64)
    faces = np.array(((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)), dtype=np.int32)
    tetrahedron = Mesh(corners_of_wedge, faces)
    scene = to.Scene(planar_arm)
    for place, (name, shape) in enumerate(
        {
            "box": corners,
            "ball": to.Sphere(0.1),
            "can": to.Cylinder(0.1, 0.3),
            "hat": to.Cone(0.1, 0.3),
            "pill": to.Capsule(0.1, 0.3),
            "wedge": tetrahedron,
        }.items()
    ):
        scene = scene.add(name, shape, to.placement((2.0 + place, 0.0, 0.0), rpy=(0.1, 0.2, 0.3)))
    tip = planar_arm.links[-1]
    scene = scene.add(
        "held", to.Box(0.02, 0.02, 0.02), to.placement((0.0, 0.0, 0.3)), frame=tip, touch_links=[tip]
    )
    scene = scene.add("box/lid", (), to.placement((0.0, 0.0, 0.15)), frame="box")
    scene = scene.add("corner", (), to.placement((1.0, 1.0, 0.0)))
    return scene


@pytest.mark.parametrize("generation", Generation)
def test_a_scene_comes_back_as_it_was(full: to.Scene, generation: Generation) -> None:
    positions = full.robot.positions({})
    message = scene_message(full, positions, ALL)
    document = json.loads(json.dumps(encode(message, generation)))
    received = decode(PlanningScene, document, generation)
    assert received == message
    again = edited(to.Scene(full.robot), received)
    assert leaves(encode(scene_message(again, positions, ALL))) == leaves(encode(message))
    assert {"box/lid", "corner", "held"} <= set(again.objects)
    assert again.holder("held").link == full.holder("held").link


def test_parts_of_a_scene(full: to.Scene) -> None:
    asked, positions = PlanningSceneComponents, full.robot.positions({})
    names = scene_message(full, positions, asked.WORLD_OBJECT_NAMES)
    assert [each.id for each in names.world.collision_objects][:2] == ["box", "ball"]
    assert not names.world.collision_objects[0].primitives
    state = scene_message(full, positions, asked.ROBOT_STATE).robot_state
    assert state.joint_state.name and not state.attached_collision_objects
    held = scene_message(full, positions, asked.ROBOT_STATE_ATTACHED_OBJECTS).robot_state
    assert [each.object.id for each in held.attached_collision_objects] == ["held"]
    assert not scene_message(full, positions, asked.SCENE_SETTINGS).world.collision_objects


def test_add_move_append_remove(planar_arm: to.Robot) -> None:
    scene = edited(to.Scene(planar_arm), difference(CollisionObject(id="a", pose=at(2.0), primitives=SPHERE)))
    scene = edited(scene, difference(CollisionObject(id="a", pose=at(3.0), operation=CollisionObject.MOVE)))
    assert scene.holder("a").placement.translation.tolist() == [3.0, 0.0, 0.0]
    more = CollisionObject(id="a", pose=at(3.5), primitives=SPHERE, operation=CollisionObject.APPEND)
    scene = edited(scene, difference(more))
    assert [part[1].translation.tolist() for part in scene.object("a").parts] == [[0, 0, 0], [0.5, 0, 0]]
    gone = CollisionObject(id="a", operation=CollisionObject.REMOVE)
    assert "a" not in edited(scene, difference(gone)).objects
    assert not edited(scene, difference(CollisionObject(operation=CollisionObject.REMOVE))).objects


def test_attached_objects(full: to.Scene) -> None:
    tip = full.robot.links[-1]
    taken = AttachedCollisionObject(tip, CollisionObject(id="ball"), [tip], weight=1.0)
    scene = edited(full, difference(attached=(taken,)))
    assert scene.holder("ball").link == full.holder("held").link
    grown = CollisionObject(Header(frame_id=tip), at(0.4), "held", primitives=SPHERE, operation=2)
    scene = edited(scene, difference(attached=(AttachedCollisionObject(tip, grown, ["box"]),)))
    assert len(scene.object("held").parts) == 2
    assert "box" in scene.object("held").touch_links
    gone = CollisionObject(operation=CollisionObject.REMOVE)
    scene = edited(scene, difference(attached=(AttachedCollisionObject(tip, gone),)))
    assert scene.holder("ball").link == scene.holder("held").link == "world"
    moved = AttachedCollisionObject(tip, CollisionObject(id="held", operation=CollisionObject.MOVE))
    with pytest.raises(FileFormatError, match="MOVE of an attached object"):
        edited(full, difference(attached=(moved,)))


def test_a_full_state_replaces_all_attached_objects(full: to.Scene) -> None:
    joint = full.robot.joint_names[0]
    state = RobotState(JointState(name=[joint], position=[0.1]))
    scene = edited(full, PlanningScene(robot_state=state, is_diff=True))
    assert "held" not in scene.objects and "box" in scene.objects
    kept = edited(full, PlanningScene(robot_state=RobotState(state.joint_state, is_diff=True), is_diff=True))
    assert "held" in kept.objects
    assert "held" in edited(full, PlanningScene(is_diff=True)).objects


def test_a_fixed_frame_is_put_elsewhere(full: to.Scene) -> None:
    message = scene_message(full, full.robot.positions({}), PlanningSceneComponents.TRANSFORMS)
    message.is_diff = True
    message.fixed_frame_transforms[0].transform.translation.x = 4.0
    scene = edited(full, message)
    assert scene.object("corner").placement.translation[0] == 4.0


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        (
            {"world": {"octomap": {"octomap": {"data": [1, 2]}}}},
            FileFormatError,
            "octomaps are not supported",
        ),
        ({"link_padding": [{"link_name": "nose", "padding": 0.1}]}, FrameNotFound, "nose"),
        ({"world": {"collision_objects": [{"id": "x", "operation": 7}]}}, FileFormatError, "operation"),
        ({"world": {"collision_objects": [{"id": "x"}]}}, FileFormatError, "has no shape"),
    ],
)
def test_impossible_edits_are_refused(full: to.Scene, change: dict[str, Any], error: type, said: str) -> None:
    with pytest.raises(error, match=said):
        edited(full, decode(PlanningScene, {**change, "is_diff": True}))
