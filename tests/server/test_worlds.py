"""What `World(url=...)` asks, asked by others: hostile values are refused with the place."""

import copy
import json
import random
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any, cast

import numpy as np
import pytest

import trajopt as to
from trajopt.files.bundle.containers import message_of
from trajopt.server import Answer, RequestRefused, SessionState, Watch
from trajopt.server.move_group.functions import Settings
from trajopt.server.operations import OPERATIONS
from trajopt.values.documents.document import Node
from trajopt.values.errors import FileFormatError, TrajoptError

START = np.array((0.0, 0.4))
NAMES = ("hold", "call", "drive")
WRONG: tuple[Any, ...] = (
    *(None, 0, -1, 1e308, "", "../../etc/passwd", [], {}, [[]], True, [1.0] * 7),
    *({"known": "robot"}, {"known": "scene"}, {"shared": 0}, {"number": "nan"}, {"set": [1]}),
    *({"array": [1, 2], "type": "float64"}, {"kind": "Sphere", "radius": -1}, {"kind": "Robot"}),
    *({"map": {"a": 1}}, {"pairs": [[1, 2]]}),
)
Place = tuple[Any, ...]


@pytest.fixture(scope="module")
def held() -> SessionState:
    robot = to.load("planar2")
    scene = to.Scene(robot).add("ball", to.Sphere(0.1), to.placement((0.65, 0.65, 0.1)))
    corners = 0.05 * np.random.default_rng(0).normal(size=(30, 3))
    return SessionState(
        "planar2", scene.add("hull", to.convex(corners), to.placement((0.9, -0.9, 0.1))), START
    )


@pytest.fixture(scope="module")
def honest(held: SessionState) -> dict[str, Any]:
    """Requests as a world sends them."""
    known: dict[str, object] = {"robot": held.scene.robot}
    problem = to.Problem(scene=held.scene, start=START, goal={"joint1": 0.2, "joint2": 0.1})
    motion = to.plan(problem).require().trajectory
    scene = message_of(held.scene, known)
    return {
        "hold": {"scene": scene},
        "call": {
            "function": "solved",
            "arguments": message_of({"problem": problem}, known),
            "settings": message_of(vars(Settings()), {}),
        },
        "drive": {"scene": scene, "group": problem.group, "trajectory": message_of(motion, {}), "speed": 0},
    }


def answered(name: str, document: object, state: SessionState, watch: Watch | None = None) -> Answer:
    node = Node(json.loads(json.dumps(document)), "request")
    return OPERATIONS[name].run(state, node, watch or Watch(5.0))


def places(value: Any, at: Place = ()) -> Iterator[Place]:
    """Yield the place of everything in a document."""
    if at:
        yield at
    if isinstance(value, dict):
        for key, inner in cast("dict[str, Any]", value).items():
            yield from places(inner, (*at, key))
    if isinstance(value, list):
        for number, inner in enumerate(cast("list[Any]", value)):
            yield from places(inner, (*at, number))


def member(document: Any, at: Place) -> Any:
    for key in at:
        document = document[key]
    return document


@pytest.mark.parametrize("name", NAMES)
def test_honest_requests_are_answered(name: str, held: SessionState, honest: dict[str, Any]) -> None:
    answer = answered(name, honest[name], held)
    json.dumps(answer.document)
    if name == "drive":
        assert answer.state is not None
        assert answer.state.positions == pytest.approx([0.2, 0.1], abs=1e-3)


def test_hundreds_of_changed_requests_are_refused_or_answered(
    held: SessionState, honest: dict[str, Any]
) -> None:
    """What raises anything but a typed error would be told as a fault of the server."""
    rng, ended = random.Random(3), Counter[str]()
    for _ in range(400):
        name = rng.choice(NAMES)
        document = copy.deepcopy(honest[name])
        at = rng.choice(list(places(document)))
        holder = member(document, at[:-1])
        if isinstance(holder, dict) and rng.random() < 0.2:
            del holder[at[-1]]
        else:
            holder[at[-1]] = copy.deepcopy(rng.choice(WRONG))
        try:
            answered(name, document, held)
            ended["answered"] += 1
        except TrajoptError as error:
            assert str(error)
            ended["refused"] += 1
    assert ended["refused"] > 300


Change = Callable[[dict[str, Any]], object]
CHANGES: dict[str, tuple[str, Change, str]] = {
    "a function that is none": ("call", lambda d: d.update(function="eval"), "must be one of solved"),
    "a method of Python's": ("call", lambda d: d.update(function="__class__"), "must be one of solved"),
    "an argument of nobody": (
        "call",
        lambda d: d["arguments"]["value"]["map"].update(shell="id"),
        "shell",
    ),
    "a speed that runs back": ("drive", lambda d: d.update(speed=-1), "speed: must not be negative"),
    "a setting of nobody": ("call", lambda d: d["settings"]["value"]["map"].update(shell="id"), "shell"),
}


@pytest.mark.parametrize(("name", "change", "reason"), CHANGES.values(), ids=CHANGES)
def test_a_refusal_names_the_place(
    name: str, change: Change, reason: str, held: SessionState, honest: dict[str, Any]
) -> None:
    document = copy.deepcopy(honest[name])
    change(document)
    with pytest.raises(TrajoptError, match=reason):
        answered(name, document, held)


def test_no_robot_is_taken_from_a_request(held: SessionState) -> None:
    own = to.Scene(to.load("planar2"))
    with pytest.raises(FileFormatError, match="'Robot' is not among"):
        answered("hold", {"scene": message_of(own, {})}, held)


def test_refuses_a_request_beyond_its_size_limits(held: SessionState, honest: dict[str, Any]) -> None:
    with pytest.raises(FileFormatError, match="more than a request may"):
        answered("hold", honest["hold"], held, Watch(5.0, triangles=5))
    long = to.Trajectory(("joint1", "joint2"), np.linspace(0.0, 9.0, 500), np.zeros((500, 2)))
    request = {**honest["drive"], "trajectory": message_of(long, {})}
    with pytest.raises(FileFormatError, match="more than a request may"):
        answered("drive", request, held, Watch(5.0, points=100))


def test_the_robot_document_omits_its_file_paths(held: SessionState) -> None:
    text = json.dumps(answered("robot", {}, held).document)
    assert str(held.scene.robot.urdf_path.parent) not in text
    with pytest.raises((FileFormatError, RequestRefused), match="unknown key"):
        answered("robot", {"file": "/etc/passwd"}, held)


def test_an_object_goes_by_its_own_name(held: SessionState, honest: dict[str, Any]) -> None:
    document = copy.deepcopy(honest["hold"])
    (scene,) = (each for each in document["scene"]["shared"] if each["kind"] == "Scene")
    scene["objects"]["map"]["hull"] = scene["objects"]["map"]["ball"]
    with pytest.raises(FileFormatError, match="object 'hull' of the scene is named 'ball'"):
        answered("hold", document, held)


def driven_in(scene: to.Scene, held: SessionState, honest: dict[str, Any]) -> dict[str, Any]:
    """Return the answer to a drive whose scene changes as it begins."""
    watch = Watch(5.0)
    watch.change(lambda: scene)
    return cast("dict[str, Any]", answered("drive", honest["drive"], held, watch).document)


def test_an_obstacle_added_while_the_robot_is_driven_stops_it(
    held: SessionState, honest: dict[str, Any]
) -> None:
    alone = cast("dict[str, Any]", answered("drive", honest["drive"], held).document)
    assert alone["positions"]["joint1"] == pytest.approx(0.2, abs=1e-3) and alone["stop"] is None
    far = driven_in(held.scene.add("far", to.Sphere(0.1), to.placement((-2.0, 0.0, 0.1))), held, honest)
    assert far["positions"]["joint1"] == pytest.approx(0.2, abs=1e-3) and not far["remark"]
    elbow = held.scene.placement_of("link2", np.array((0.2, 0.1))).translation
    ahead = driven_in(held.scene.add("post", to.Sphere(0.01), to.placement(tuple(elbow))), held, honest)
    assert ahead["positions"]["joint1"] < 0.15 and ahead["stop"]["proven"]
    assert "the scene changed: link2 and post would be too near" in ahead["remark"]
    assert "contact" not in ahead["remark"]


def test_an_obstacle_added_where_the_robot_is_is_simulated(
    held: SessionState, honest: dict[str, Any]
) -> None:
    tip = held.scene.placement_of("tool", START).translation
    there = driven_in(held.scene.add("post", to.Sphere(0.03), to.placement(tuple(tip))), held, honest)
    assert "post touches tool from 0.000 s" in there["remark"]
