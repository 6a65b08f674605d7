"""Bad input to scenes and shapes: refused at once, by name, and nothing is half done."""

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from trajopt import Robot, Scene, Trajectory, load_mesh, placement
from trajopt.values.errors import (
    DuplicateObject,
    FrameNotFound,
    MeshFileError,
    ModelError,
    ObjectNotFound,
    ShapeError,
    SizeError,
    TrajoptError,
)
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Cylinder, Sphere, convex

NAN, INF = float("nan"), float("inf")
BOX = Box(0.1, 0.1, 0.1)


@pytest.fixture
def scene(planar_arm: Robot) -> Scene:
    """A table with a cup on it, and a tool in the hand."""
    return (
        Scene(planar_arm)
        .add("table", Box(0.5, 0.5, 0.1), placement((0.8, 0.0, -0.2)))
        .add("cup", Cylinder(0.03, 0.1), placement((0.0, 0.0, 0.1)), frame="table")
        .add("tool", Sphere(0.01), placement((0.1, 0.0, 0.0)), frame="hand", touch_links=["hand"])
        .allow("cup", "table")
        .with_margin(0.02, "tool", "table")
        .allow_contact("lift", "cup", "hand", first=0.5)
    )


def values(scene: Scene) -> list[object]:
    """Everything a scene says, by value."""
    objects = [
        (name, item.name, item.parts, item.placement, item.frame, item.touch_links, item.notes)
        for name, item in scene.objects.items()
    ]
    return [
        id(scene.robot),
        objects,
        dict(scene.allowed.entries),
        dict(scene.allowed.defaults),
        scene.margin,
        dict(scene.pair_margins),
        scene.allowances,
    ]


Edit = Callable[[Scene], object]

EDITS: dict[str, tuple[Edit, type[TrajoptError], str]] = {
    "duplicate id": (lambda s: s.add("cup", BOX), DuplicateObject, "'cup'"),
    "id of a link": (lambda s: s.add("hand", BOX), ModelError, "'hand'"),
    "id of the world": (lambda s: s.add("world", BOX), ModelError, "'world'"),
    "empty id": (lambda s: s.add("", BOX), ModelError, "empty"),
    "unknown frame": (lambda s: s.add("a", BOX, frame="tabel"), FrameNotFound, "'table'"),
    "unknown touch link": (lambda s: s.add("a", BOX, touch_links=["hnad"]), FrameNotFound, "'hand'"),
    "unknown object as touch link": (lambda s: s.add("a", BOX, touch_links=["cpu"]), FrameNotFound, "'cup'"),
    "remove unknown": (lambda s: s.remove("cap"), ObjectNotFound, "'cup'"),
    "remove what holds": (lambda s: s.remove("table"), ModelError, "'cup'"),
    "move unknown": (lambda s: s.move("cap", placement()), ObjectNotFound, "'cup'"),
    "move to unknown frame": (lambda s: s.move("cup", placement(), frame="hend"), FrameNotFound, "'hand'"),
    "move into itself": (lambda s: s.move("cup", placement(), frame="cup"), ModelError, "its own frame"),
    "move into what it holds": (
        lambda s: s.move("table", placement(), frame="cup"),
        ModelError,
        "its own frame",
    ),
    "attach unknown": (lambda s: s.attach("cap", "hand", placement=placement()), ObjectNotFound, "'cup'"),
    "attach to unknown": (lambda s: s.attach("cup", "hnd", placement=placement()), FrameNotFound, "'hand'"),
    "attach to what stands in the world": (
        lambda s: s.attach("cup", "table", placement=placement()),
        ModelError,
        "'table' is fixed in the world.*move 'cup'",
    ),
    "attach to the world": (lambda s: s.attach("cup", "world", placement=placement()), ModelError, "'world'"),
    "attach to itself": (lambda s: s.attach("tool", "tool", placement=placement()), ModelError, "its own"),
    "tool of a taken name": (lambda s: s.with_tool("cup", "hand"), ModelError, "an object"),
    "tool of a link's name": (lambda s: s.with_tool("hand", "hand"), ModelError, "a frame of the robot"),
    "tool of no name": (lambda s: s.with_tool("", "hand"), ModelError, "empty"),
    "tool twice": (lambda s: s.with_tool("tip", "hand").with_tool("tip", "hand"), ModelError, "'tip'"),
    "object of a tool's name": (lambda s: s.with_tool("tip", "hand").add("tip", BOX), ModelError, "'tip'"),
    "tool on unknown": (lambda s: s.with_tool("tip", "hnad"), FrameNotFound, "'hand'"),
    "tool on the world": (lambda s: s.with_tool("tip", "world"), ModelError, "world"),
    "tool moved to the world": (
        lambda s: s.with_tool("tip", "hand").move("tip", placement(), frame="world"),
        ModelError,
        "world",
    ),
    "tool in its own frame": (
        lambda s: s.with_tool("tip", "hand").move("tip", placement(), frame="tip"),
        ModelError,
        "its own",
    ),
    "tool placed nowhere": (
        lambda s: s.with_tool("tip", "hand", placement=3),
        ShapeError,
        "placement of 'tip'",
    ),
    "remove what a tool is on": (lambda s: s.with_tool("tip", "cup").remove("cup"), ModelError, "'tip'"),
    "margin of one thing": (lambda s: s.with_margin(0.01, "cup", "cup"), ModelError, "one thing"),
    "attach nowhere": (lambda s: s.attach("cup", "hand"), ModelError, "placement"),
    "attach twice over": (
        lambda s: s.attach("cup", "hand", placement=placement(), at=s.robot.positions()),
        ModelError,
        "placement",
    ),
    "attach, unknown touch link": (
        lambda s: s.attach("cup", "hand", placement=placement(), touch_links=["left_fingr"]),
        FrameNotFound,
        "'left_finger'",
    ),
    "detach unknown": (lambda s: s.detach("cap", at=s.robot.positions()), ObjectNotFound, "'cup'"),
    "detach from the world": (lambda s: s.detach("cup", at=s.robot.positions()), ModelError, "'cup'"),
    "allow unknown": (lambda s: s.allow("cup", "tabel"), FrameNotFound, "'table'"),
    "allow unknown with all": (lambda s: s.allow("cap"), FrameNotFound, "'cup'"),
    "margin with unknown": (lambda s: s.with_margin(0.01, "cup", "hnad"), FrameNotFound, "'hand'"),
    "margin with one": (lambda s: s.with_margin(0.01, "cup"), ModelError, "both"),
    "negative margin": (lambda s: s.with_margin(-0.01), ShapeError, "negative"),
    "margin not a number": (lambda s: s.with_margin(NAN), ShapeError, "margin"),
    "infinite margin": (lambda s: s.with_margin(INF, "cup", "hand"), ShapeError, "margin"),
    "contact of unknown": (lambda s: s.allow_contact("c", "cap", "hand", first=1.0), FrameNotFound, "'cup'"),
    "contact with unknown": (
        lambda s: s.allow_contact("c", "cup", "hnad", first=1.0),
        FrameNotFound,
        "'hand'",
    ),
    "contact at no time": (lambda s: s.allow_contact("c", "cup", "hand"), ModelError, "'c'"),
    "negative contact": (
        lambda s: s.allow_contact("c", "cup", "hand", last=-1.0),
        ShapeError,
        "last",
    ),
    "contact of infinite depth": (
        lambda s: s.allow_contact("c", "cup", "hand", depth=INF, first=1.0),
        ShapeError,
        "depth",
    ),
    "ask for unknown": (lambda s: s.object("cap"), ObjectNotFound, "'cup'"),
    "holder of unknown": (lambda s: s.holder("hend"), FrameNotFound, "'hand'"),
    "placement of unknown": (
        lambda s: s.placement_of("hend", s.robot.positions()),
        FrameNotFound,
        "'hand'",
    ),
    "size in millimetres": (lambda s: s.add("a", Box(300, 200, 150)), SizeError, "millimetres|0.3 m"),
    "no orientation": (
        lambda s: s.move("cup", placement((0, 0, 0), quaternion=(0, 0, 0, 0))),
        ShapeError,
        "no length",
    ),
}


@pytest.mark.parametrize("case", EDITS)
def test_bad_edit_is_refused_and_changes_nothing(scene: Scene, case: str) -> None:
    edit, error, message = EDITS[case]
    before = values(scene)
    with pytest.raises(error, match=message):
        edit(scene)
    assert values(scene) == before


def test_good_edits_leave_the_old_scene_alone(scene: Scene) -> None:
    before = values(scene)
    rest = scene.robot.positions()
    scene.add("new", BOX)
    scene.remove("cup")
    scene.move("cup", placement((1.0, 0.0, 0.0)), frame="world")
    scene.attach("cup", "hand", at=rest)
    scene.detach("tool", at=rest)
    scene.allow("cup")
    scene.with_margin(0.5)
    scene.allow_contact("more", "cup", "fore", last=1.0)
    assert values(scene) == before


SIZES: dict[str, Callable[[float], object]] = {
    "box": lambda size: Box(0.1, size, 0.1),
    "sphere": Sphere,
    "cylinder radius": lambda size: Cylinder(size, 0.1),
    "cylinder length": lambda size: Cylinder(0.1, size),
    "capsule radius": lambda size: Capsule(size, 0.1),
    "capsule length": lambda size: Capsule(0.1, size),
    "cone radius": lambda size: Cone(size, 0.1),
    "cone length": lambda size: Cone(0.1, size),
}


@pytest.mark.parametrize("shape", SIZES)
@pytest.mark.parametrize("size", [0.0, -0.1, 60.0, 1e9])
def test_size_out_of_range(shape: str, size: float) -> None:
    with pytest.raises(SizeError, match="must be positive" if size <= 0.0 else "in metres"):
        SIZES[shape](size)


@pytest.mark.parametrize("shape", SIZES)
@pytest.mark.parametrize("size", [NAN, INF, -INF])
def test_size_not_finite(shape: str, size: float) -> None:
    with pytest.raises(ShapeError, match="not finite"):
        SIZES[shape](size)


def test_a_size_that_is_not_a_number_is_refused() -> None:
    with pytest.raises(ShapeError, match=r"Sphere\.radius"):
        Sphere("large")  # type: ignore[arg-type]


NO_NUMBERS = ("1", b"1", True, np.True_, np.array("1"), 1j, np.datetime64(1, "s"), None, [1, 2])


@pytest.mark.parametrize("value", NO_NUMBERS, ids=repr)
def test_values_that_numpy_would_convert_are_refused(value: object) -> None:
    with pytest.raises(ShapeError, match=r"Box\.x: must be (a|one) number"):
        Box(value, 1.0, 1.0)  # type: ignore[arg-type]
    with pytest.raises(ShapeError, match=r"hz: must be (a|one) number"):
        Trajectory(("a",), [0.0, 1.0], [[0.0], [1.0]]).sampled(value)  # type: ignore[arg-type]
    with pytest.raises(ShapeError, match="xyz: "):
        placement([value] * 3)  # type: ignore[arg-type, list-item]


@pytest.mark.parametrize(
    "value", [1, np.int32(1), np.float32(1.0), np.array(1), Fraction(1), Decimal(1)], ids=repr
)
def test_all_kinds_of_numbers_are_taken(value: float) -> None:
    assert Box(value, 1.0, 1.0).x == 1.0 and placement([value] * 3).translation.tolist() == [1.0, 1.0, 1.0]


@pytest.mark.parametrize(
    "points",
    [np.zeros((3, 3)), np.zeros((5, 3)), np.eye(4)[:, :3] * [1, 1, 0], [[NAN, 0, 0]] * 4],
    ids=["few", "one point", "flat", "not finite"],
)
def test_hull_without_volume(points: np.ndarray) -> None:
    with pytest.raises(ShapeError, match="points"):
        convex(points)


def test_hull_of_the_wrong_shape() -> None:
    with pytest.raises(ShapeError, match="shape"):
        convex(np.zeros((4, 2)))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"xyz": (0.0, NAN, 0.0)}, "xyz"),
        ({"xyz": (0.0, INF, 0.0)}, "xyz"),
        ({"xyz": (0.0, 0.0)}, "shape"),
        ({"rpy": (0.0, 0.0, NAN)}, "rpy"),
        ({"quaternion": (0.0, 0.0, 0.0, 0.0)}, "no length"),
        ({"quaternion": (0.0, 0.0, NAN, 1.0)}, "quaternion"),
        ({"rotation": -np.eye(3)}, "right-handed"),
        ({"rotation": 2.0 * np.eye(3)}, "orthonormal"),
        ({"rpy": (0.0, 0.0, 0.0), "rotation": np.eye(3)}, "several"),
    ],
)
def test_placement(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ShapeError, match=message):
        placement(**arguments)  # type: ignore[arg-type]


def test_mesh_file_is_missing(tmp_path: Path) -> None:
    with pytest.raises(MeshFileError, match="nothing\\.stl"):
        load_mesh(tmp_path / "nothing.stl")


@pytest.mark.parametrize("name", ["empty.stl", "empty.obj", "empty.dae"])
def test_mesh_file_is_empty(tmp_path: Path, name: str) -> None:
    (tmp_path / name).touch()
    with pytest.raises(MeshFileError, match=name):
        load_mesh(tmp_path / name)


def test_the_message_names_near_matches(scene: Scene) -> None:
    with pytest.raises(FrameNotFound) as caught:
        scene.add("a", BOX, frame="left_fingre")
    assert caught.value.name == "left_fingre"
    assert caught.value.near[0] == "left_finger"
    assert "did you mean 'left_finger'" in str(caught.value)
