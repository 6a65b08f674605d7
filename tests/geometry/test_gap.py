"""How deep an object that is carried stands in the links that move with it."""

import pytest

import trajopt as to
from trajopt.geometry.geometry import gap, inside_carriers

BETWEEN = to.placement()


@pytest.fixture(scope="module")
def panda() -> to.Scene:
    return to.Scene(to.load("panda"))


def asked(scene: to.Scene, opened: float = 0.0) -> to.Problem:
    start = {**scene.robot.state("ready", group="panda_arm"), "panda_finger_joint1": opened}
    return to.Problem(scene=scene, group="panda_arm", start=start, goal={"panda_joint1": 0.4})


def test_gap_matches_the_closed_form() -> None:
    ball, at = to.Sphere(0.1), to.placement((0.5, 0.0, 0.0))
    assert gap(to.placement(), to.Box(0.2, 0.2, 0.2), at, ball) == pytest.approx(0.3)
    assert gap(to.placement((0.35, 0.0, 0.0)), to.Box(0.2, 0.2, 0.2), at, ball) == pytest.approx(-0.05)


@pytest.mark.parametrize("touch_links", [(), ("panda_leftfinger", "panda_rightfinger")])
def test_an_object_inside_a_finger_is_reported_with_the_problem(
    panda: to.Scene, touch_links: tuple[str, ...]
) -> None:
    """Fingers are no joints of the arm's group: nothing else would say so, with touch links or without."""
    cup = to.Box(0.03, 0.2, 0.03)
    problem = asked(panda.add("cup", cup, BETWEEN, frame="panda_hand_tcp", touch_links=touch_links))
    found = inside_carriers(problem.reduced)
    assert [words.split(" inside ")[1].split(":")[0] for words in found] == [
        "panda_leftfinger",
        "panda_rightfinger",
    ]
    assert all(words in str(problem) for words in found)
    depth = float(found[0].split("cup is ")[1].split(" mm")[0])
    assert 10.0 < depth < 30.0, "the finger is 20 mm wide, and the cup goes all the way through it"


def test_objects_between_fingers_or_in_the_world_are_not_reported(panda: to.Scene) -> None:
    held = panda.add("pen", to.Box(0.02, 0.02, 0.02), BETWEEN, frame="panda_hand_tcp")
    hand = panda.placement_of("panda_hand_tcp", panda.robot.positions("ready"))
    for scene in (held, panda.add("block", to.Box(0.1, 0.1, 0.1), hand)):
        problem = asked(scene, opened=0.03)
        assert inside_carriers(problem.reduced) == ()
        assert "carried " not in str(problem)
