"""Rollouts among dynamic obstacles: contacts, and their times."""

from collections.abc import Callable

import numpy as np
import pytest

import trajopt as to
from tests.simulation.conftest import reduced_all, smooth
from trajopt.robot.robot import Robot
from trajopt.simulation import ContactInterval, Rollout, build_spec, simulate
from trajopt.values.shapes.shapes import Shape

Pendulum = Callable[..., Robot]
BALL = to.Sphere(0.05)
"""The tip of the pendulum, a ball of 50 mm too, rests 0.5 m along x and 1 m above the ground."""
SHAPES = (BALL, to.Box(0.1, 0.1, 0.1), to.Cylinder(0.05, 0.1), to.Capsule(0.05, 0.04), to.Cone(0.05, 0.1))


def held(scene: to.Scene, seconds: float = 1.0) -> Rollout:
    """Simulate the pendulum held level."""
    reduced = reduced_all(scene)
    level = np.zeros(1)
    return simulate(reduced, smooth(reduced, level, level, seconds))


def past(y: float, *, speed: float = 1.0) -> to.Track:
    """Return a track that goes past the tip along y from 0.5 m beside it, in a second at 1 m/s."""
    ends = [to.placement((0.5 + y, side, 1.0)) for side in (-0.5, 0.5)]
    return to.Track.through((0.0, 1.0 / speed), ends)


def touch(rollout: Rollout) -> ContactInterval:
    """Return the only contact."""
    (contact,) = rollout.contacts
    return contact


def test_passing_ball_touches_at_the_geometric_time(pendulum: Pendulum) -> None:
    scene = to.Scene(pendulum())
    assert not held(scene.add("ball", BALL, motion=past(0.11))).contacts
    contact = touch(held(scene.add("ball", BALL, motion=past(0.06))))
    assert set(contact.pair) == {"tip", "ball"}
    # Two balls of 50 mm, 60 mm beside each other: they touch where 80 mm along the way are left.
    assert contact.start == pytest.approx(0.42, abs=0.004)
    assert 0.03 < contact.depth < 0.041, "what moves yields to nothing"


def test_robot_is_pushed_by_a_moving_obstacle(pendulum: Pendulum) -> None:
    up = to.Track.through((0.0, 1.0), [to.placement((0.5, 0.0, z)) for z in (0.6, 0.95)])
    rollout = held(to.Scene(pendulum(effort=10.0)).add("ball", BALL, motion=up))
    assert rollout.positions[-1, 0] > 0.02
    assert rollout.collisions and "ball touches tip" in rollout.summary()


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_absent_object_touches_nothing(pendulum: Pendulum, shape: Shape) -> None:
    scene, there = to.Scene(pendulum()), to.placement((0.5, 0.02, 1.02))
    gone = held(scene.add("thing", shape, there, appears=2.0))
    assert not gone.contacts and gone.tracking_error.maximum[0] < 1e-9
    short = touch(held(scene.add("thing", shape, there, appears=0.3, expires=0.5)))
    assert short.start == pytest.approx(0.3, abs=0.0021) and short.end == pytest.approx(0.5, abs=0.0021)


def test_object_on_a_link_touches_while_it_is_present(pendulum: Pendulum) -> None:
    scene = to.Scene(pendulum()).add("wall", to.Box(0.1, 0.1, 0.1), to.placement((0.65, 0.0, 1.0)))
    part = scene.add("part", BALL, to.placement((0.09, 0.0, 0.0)), frame="tip", appears=0.2, expires=0.4)
    contact = touch(held(part))
    assert set(contact.pair) == {"part", "wall"}
    assert contact.start == pytest.approx(0.2, abs=0.0021) and contact.end == pytest.approx(0.4, abs=0.0021)


def test_object_on_a_moving_object_moves_along(pendulum: Pendulum) -> None:
    scene = to.Scene(pendulum()).add("tray", to.Box(0.2, 0.2, 0.02), motion=past(0.2))
    contact = touch(held(scene.add("cup", BALL, to.placement((-0.14, 0.0, 0.0)), frame="tray")))
    assert set(contact.pair) == {"tip", "cup"} and contact.start == pytest.approx(0.42, abs=0.004)


def test_turning_object_turns(pendulum: Pendulum) -> None:
    quarter = [to.placement((1.0, 0.0, 1.0), rpy=(0.0, 0.0, turn)) for turn in (np.pi / 2, np.pi)]
    bar = to.Scene(pendulum()).add(
        "bar", to.Box(0.98, 0.02, 0.02), motion=to.Track.through((0.0, 1.0), quarter)
    )
    contact = touch(held(bar, 1.2))
    assert set(contact.pair) == {"tip", "bar"} and 0.85 < contact.start < 1.0


def test_moving_half_space_pushes(pendulum: Pendulum) -> None:
    rising = to.Track.through((0.0, 1.0), [to.placement((0.0, 0.0, z)) for z in (0.0, 1.0)])
    rollout = held(to.Scene(pendulum()).add("water", to.Plane(), motion=rising))
    assert rollout.contacts[0].start == pytest.approx(0.95, abs=0.004)


def test_an_error_of_a_track_is_noted(pendulum: Pendulum) -> None:
    known = to.Prediction(past(0.3), (0.02, 0.0, 0.0))
    scene = to.Scene(pendulum()).add("sure", BALL, motion=past(0.4))
    for name in ("ball", "other/rod", "other/tip"):
        scene = scene.add(name, BALL, motion=known)
    assert held(scene).notes == (
        "ball: simulated exactly on its track, from which it may be 20 mm away",
        "other: simulated exactly on its track, from which it may be 20 mm away",
    )


def test_static_scene_has_no_mocap_bodies(pendulum: Pendulum) -> None:
    model = build_spec(
        reduced_all(to.Scene(pendulum()).add("post", BALL, to.placement((1.0, 0, 1))))
    ).compile()
    assert model.nmocap == 0 and model.ngeom == 3


def test_attached_object_is_held(pendulum: Pendulum) -> None:
    scene = to.Scene(pendulum()).add(
        "load", to.Box(0.02, 0.02, 0.02), frame="tip", touch_links=["tip"], mass=1.5
    )
    reduced = reduced_all(scene)
    rollout = simulate(reduced, smooth(reduced, np.array([-0.4]), np.array([0.6]), 1.0))
    assert rollout.final_pose_error().position < 1e-6
    assert rollout.tracking_error.maximum[0] < 1e-3
