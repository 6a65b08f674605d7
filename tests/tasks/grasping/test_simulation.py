"""Under physics: what friction can hold is held and put where it was asked, what it cannot is told."""

from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from trajopt.simulation import Friction, render
from trajopt.tasks.grasping import (
    GraspingOptions,
    Gripper,
    PickPlaceResult,
    Place,
    Stage,
    Straight,
    grasps_of,
    pick,
    pick_and_place,
    place,
)
from trajopt.tasks.grasping.simulation import Hold, HoldLimits, PickPlaceRollout, simulate_handling
from trajopt.values.errors import ModelError, PlanningFailed
from trajopt.values.shapes.shapes import Shape

from .conftest import ANGLE, Parts, drawn, hexagonal, on_table

STOOD = to.placement((0.5, -0.2, 0.05), rpy=(0.0, 0.0, 0.3))
GRAVITY = 9.81


def put(robot: to.Robot, gripper: Gripper, scene: to.Scene, where: to.Placement) -> PickPlaceResult:
    grasps = grasps_of(scene, "thing", gripper)
    found = pick_and_place(scene, "thing", start="ready", grasps=grasps, places=Place(placement=where))
    assert found.verified, found.explain()
    return found


def right(rollout: PickPlaceRollout) -> bool:
    """Held, and within 5 mm and 3 degrees of the place asked for."""
    error = rollout.final_error
    assert error is not None
    return rollout.hold is Hold.HELD and error.position < 5e-3 and error.rotation < np.deg2rad(3.0)


@pytest.mark.parametrize("shape", [to.Box(0.05, 0.2, 0.004), to.Cylinder(0.02, 0.006)], ids=["plate", "coin"])
def test_a_flat_object_on_a_table_is_held_by_the_tips(
    panda: to.Robot, gripper: Gripper, shape: to.Box | to.Cylinder
) -> None:
    """With the pads' centres at its middle, the fingers would reach 7 mm into the table."""
    half = shape.z / 2.0 if isinstance(shape, to.Box) else shape.length / 2.0
    scene = on_table(panda, shape, to.placement((0.5, -0.2, half)), 0.1)
    carried = put(panda, gripper, scene, to.placement((0.5, 0.2, half)))
    assert carried.grasp is not None and "by the tips" in carried.grasp.name
    assert right(simulate_handling(carried))


@pytest.mark.parametrize(
    "shape",
    [to.Box(0.04, 0.06, 0.1), to.Cylinder(0.03, 0.1), hexagonal(0.05, 0.1), to.Cone(0.025, 0.1), ANGLE],
    ids=["box", "cylinder", "hexagon", "cone", "angle"],
)
def test_the_object_is_placed_at_the_goal(panda: to.Robot, gripper: Gripper, shape: Shape | Parts) -> None:
    scene = on_table(panda, shape, STOOD, mass=0.4)
    rollout = simulate_handling(put(panda, gripper, scene, to.placement((0.45, 0.25, 0.05))))
    assert right(rollout), rollout.summary()
    assert rollout.slip is None
    assert rollout.log.contacts == () and rollout.log.saturated == {}
    # Nothing touched it before the fingers closed, and nothing is inside it.
    assert rollout.disturbed.position < 1e-4
    assert rollout.settled.position < 1e-3
    assert rollout.log.deepest < 5e-4
    # In the air it touches the fingers and nothing else.
    stages = [rollout.result.segments[int(k)].stage for k in rollout.log.phases]
    carried = {
        touching
        for stage, touching in zip(stages, rollout.log.touching["thing"], strict=True)
        if stage is Stage.CARRY
    }
    assert carried == {frozenset(gripper.fingers)}
    assert rollout.log.touching["thing"][-1] == {"table"}
    assert rollout.as_dict()["hold"] == "HELD"
    assert "held the object" in rollout.summary()


@pytest.mark.parametrize(("share", "hold"), [(0.75, Hold.HELD), (1.5, Hold.SLIPPED)])
def test_the_object_slips_as_coulombs_law_states(
    panda: to.Robot, gripper: Gripper, share: float, hold: Hold
) -> None:
    """Two pads hold m g up to 2 mu F: a share of that, lifted slowly."""
    mass, force = 1.0, 30.0
    scene = on_table(panda, to.Box(0.05, 0.05, 0.1), STOOD, mass=mass)
    grasp = replace(grasps_of(scene, "thing", gripper, force=force)[0], lift=Straight(0.03))
    slow = GraspingOptions(velocity_scaling=0.5, acceleration_scaling=0.1)
    found = pick(scene, "thing", start="ready", grasps=[grasp], options=slow)
    friction = Friction(pads=mass * GRAVITY / (2.0 * force * share))
    rollout = simulate_handling(found, friction=friction)
    assert rollout.hold is hold, rollout.summary()
    assert (rollout.slip is None) == (hold is Hold.HELD)
    assert rollout.final_error is None
    if rollout.slip is not None:
        assert rollout.slip.stage is Stage.LIFT
        assert "slipped in the fingers" in rollout.summary() and "LIFT" in rollout.summary()
        # It stands where it stood.
        left = rollout.log.placements["thing"][-1]
        assert np.linalg.norm(left.translation - STOOD.translation) < 0.01


def test_a_slip_is_beyond_the_limits_given(panda: to.Robot, gripper: Gripper) -> None:
    scene = on_table(panda, to.Box(0.05, 0.05, 0.1), STOOD, mass=0.4)
    found = pick(scene, "thing", start="ready", grasps=grasps_of(scene, "thing", gripper))
    strict = simulate_handling(found, limits=HoldLimits(position=1e-7))
    assert strict.hold is Hold.SLIPPED
    assert strict.slip is not None and strict.slip.stage is Stage.LIFT
    assert strict.slip.worst == strict.shift


def test_a_grasp_beside_the_object_is_lost(panda: to.Robot, gripper: Gripper) -> None:
    """The plan takes the asked width on trust; physics does not."""
    scene = on_table(panda, to.Box(0.05, 0.05, 0.1), STOOD, mass=0.4)
    grasp = replace(grasps_of(scene, "thing", gripper)[0], width=0.055, force=1e-3)
    rollout = simulate_handling(pick(scene, "thing", start="ready", grasps=[grasp]))
    assert rollout.hold is Hold.LOST, rollout.summary()


def test_results_that_cannot_be_simulated_are_refused(panda: to.Robot, gripper: Gripper) -> None:
    scene = on_table(panda, to.Box(0.05, 0.05, 0.1), STOOD, mass=0.0)
    grasps = grasps_of(scene, "thing", gripper)[:1]
    taken = pick(scene, "thing", start="ready", grasps=grasps)
    with pytest.raises(ModelError, match="'thing' has no mass"):
        simulate_handling(taken)
    there = Place(placement=to.placement((0.45, 0.25, 0.05)))
    held = place(taken.final_scene, "thing", start=taken.final_positions, places=there)
    with pytest.raises(ModelError, match="in the hand from the beginning"):
        simulate_handling(held)
    nowhere = pick(scene, "thing", start="ready", grasps=[replace(grasps[0], opening=0.2)])
    with pytest.raises(PlanningFailed):
        simulate_handling(nowhere)


@pytest.mark.slow
def test_nineteen_of_twenty_random_objects_end_in_their_place(panda: to.Robot, gripper: Gripper) -> None:
    rng = np.random.default_rng(2026)
    ended: list[str] = []
    for _ in range(20):
        scene, where = drawn(panda, rng)
        rollout = simulate_handling(put(panda, gripper, scene, where))
        if not right(rollout):
            ended.append(rollout.summary())
    assert len(ended) <= 1, ended


@pytest.mark.slow
def test_a_picture_shows_the_object_where_it_is(
    panda: to.Robot, gripper: Gripper, tmp_path_factory: pytest.TempPathFactory
) -> None:
    from PIL import Image

    scene = on_table(panda, to.Box(0.04, 0.06, 0.1), STOOD)
    log = simulate_handling(put(panda, gripper, scene, to.placement((0.45, 0.25, 0.05)))).log
    folder = tmp_path_factory.mktemp("pictures")
    moments = (0.0, float(log.times[-1]))
    places = []
    for k, moment in enumerate(moments):
        file = render(log.reduced, log, folder / f"{k}.png", moments=[moment], width=320, height=240)
        picture = np.asarray(Image.open(file)).astype(float)[..., :3]
        orange = (picture[..., 0] > 150) & (picture[..., 1] < 150) & (picture[..., 2] < 90)
        assert orange.sum() > 20
        places.append(np.argwhere(orange).mean(axis=0))
    assert np.linalg.norm(places[1] - places[0]) > 20.0
