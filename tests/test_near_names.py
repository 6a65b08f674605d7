"""What is suggested for a name that is not found: frames for a frame, objects for an object."""

import numpy as np
import pytest

import trajopt as to
from trajopt.optimise.kinematics import forward_kinematics
from trajopt.values.errors import FrameNotFound, ObjectNotFound

AT = to.placement((0.4, 0.0, 0.3))


@pytest.fixture(scope="module")
def scene() -> to.Scene:
    ball = to.Sphere(0.05)
    return to.Scene(to.load("panda")).add("panda_hat", ball, AT).add("hand", ball, AT).add("table", ball, AT)


def test_a_frame_is_answered_with_frames(scene: to.Scene) -> None:
    for call in (
        lambda: to.Problem(
            scene=scene, group="panda_arm", start="ready", goal=to.frame_placement("panda_hadn", AT)
        ),
        lambda: scene.placement_of("panda_hadn", np.zeros(9)),
        lambda: scene.allow("panda_hadn", "table"),
        lambda: scene.with_tool("tcp", on="panda_hadn"),
        lambda: forward_kinematics(problem(scene).reduced, "panda_hadn", np.zeros(7)),
    ):
        with pytest.raises(FrameNotFound, match="'panda_hand' or 'panda_hand_tcp'") as raised:
            call()
        assert not set(raised.value.near) & set(scene.objects)


def test_an_object_that_is_nearer_than_every_frame_is_named_first(scene: to.Scene) -> None:
    with pytest.raises(FrameNotFound) as raised:
        scene.add("cup", to.Sphere(0.03), frame="tabel")
    assert raised.value.near[0] == "table"


def test_an_object_is_answered_with_objects(scene: to.Scene) -> None:
    with pytest.raises(ObjectNotFound, match="did you mean 'table'") as raised:
        scene.object("tabel")
    assert set(raised.value.near) <= set(scene.objects)
    for frame in ("panda_hand", "panda_link8"):
        with pytest.raises(ObjectNotFound, match="it is a frame of the robot"):
            scene.object(frame)
    with pytest.raises(ObjectNotFound, match="it is a frame of the robot"):
        scene.remove("panda_hand")


def test_a_name_without_near_matches_is_answered_with_the_known_ones(scene: to.Scene) -> None:
    for name in ("tool0", "wrist", "tcp"):
        with pytest.raises(FrameNotFound, match="known: panda_hand, panda_hand_tcp, ") as raised:
            scene.placement_of(name, np.zeros(9))
        assert not raised.value.near


def problem(scene: to.Scene) -> to.Problem:
    return to.Problem(scene=scene, group="panda_arm", start="ready", goal="ready")


HINTS = {"plan": r"require\(\)", "success": "verified", "error": "reason", "error_code": "status"}


@pytest.mark.parametrize("name", HINTS)
def test_results_hint_at_names_of_other_libraries(name: str) -> None:
    start = {"joint1": 0.0, "joint2": 0.0}
    result = to.plan(to.Problem(scene=to.Scene(to.load("planar2")), start=start, goal=start))
    with pytest.raises(AttributeError, match=rf"no attribute '{name}': use .*{HINTS[name]}"):
        getattr(result, name)
    assert not hasattr(result, "nonsense")


def test_scenes_hint_at_names_of_other_libraries(planar_arm: to.Robot) -> None:
    with pytest.raises(AttributeError, match=r"scene\.add\(name, to\.Box"):
        _ = to.Scene(planar_arm).add_box  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match=r"no attribute 'nonsense'$"):
        _ = to.Scene(planar_arm).nonsense  # type: ignore[attr-defined]


def test_a_transposed_matrix_is_named(planar_arm: to.Robot) -> None:
    matrix = to.placement((0.1, 0.2, 0.3)).homogeneous.T
    with pytest.raises(to.TrajoptError, match=r"transposed, give matrix\.T"):
        to.Scene(planar_arm).add("ball", to.Sphere(0.1), matrix)
