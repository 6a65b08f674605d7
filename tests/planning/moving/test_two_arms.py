"""Two arms in one cell: one moves along its own plan, the other is planned beside it."""

import coal
import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from tests.planning.moving.test_dynamic_search import GOAL, START
from trajopt.geometry.geometry import collision_geometry
from trajopt.scene.reduced import ReducedModel

SAMPLES = 300


@pytest.fixture(scope="module")
def cell() -> to.Scene:
    try:
        return to.Scene(to.load("panda"))
    except to.MissingExtra as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def other(cell: to.Scene) -> to.Result:
    held = cell.add("rod", to.Cylinder(0.02, 0.3), to.placement((0.0, 0.0, 0.1)), frame="panda_hand")
    held = held.attach("rod", "panda_hand", placement=to.placement((0.0, 0.0, 0.1)))
    held = held.allow("rod", "panda_leftfinger").allow("rod", "panda_rightfinger")
    return to.plan(to.Problem(scene=held, group="panda_arm", start=START, goal=GOAL))


def apart(one: to.Result, other: to.Result, base: to.Placement, start: float) -> float:
    """Return the least distance of two arms that really move as planned, at many times [m]."""
    mine, its = one.problem.reduced, other.problem.reduced
    motion, theirs = one.require().trajectory, other.require().trajectory
    request, result, least = coal.DistanceRequest(), coal.DistanceResult(), np.inf
    for time in np.linspace(0.0, motion.duration, SAMPLES).tolist():
        first = shapes(mine, motion(time), to.placement())
        for geometry, where in first:
            for shape, there in shapes(its, theirs(max(time - start, 0.0)), base):
                result.clear()
                least = min(least, coal.distance(geometry, where, shape, there, request, result))
    return least


def shapes(
    reduced: ReducedModel, positions: np.ndarray, base: to.Placement
) -> list[tuple[coal.CollisionGeometry, coal.Transform3s]]:
    data = reduced.model.createData()
    pin.forwardKinematics(reduced.model, data, reduced.configuration(positions))
    found = []
    for body in reduced.bodies:
        if body.joint:
            at = data.oMi[body.joint]
            where = base * to.Placement(at.rotation, at.translation) * body.placement
            transform = coal.Transform3s(where.rotation, where.translation)
            found.append((collision_geometry(body.shape), transform))
    return found


@pytest.mark.parametrize(("x", "start"), [(1.7, 0.0), (1.1, 0.0), (1.1, -0.3)])
def test_an_arm_passes_another_whose_motion_is_known(
    cell: to.Scene, other: to.Result, x: float, start: float
) -> None:
    base = to.placement((x, 0.0, 0.0), rpy=(0.0, 0.0, np.pi))
    scene = cell.with_robot_in_motion("left", other, base=base, start=start)
    assert "left/rod" in scene.objects and "left/panda_link0" not in scene.changing
    alone = to.plan(to.Problem(scene=cell, group="panda_arm", start=START, goal=GOAL)).require().trajectory
    result = to.plan(to.Problem(scene=scene, group="panda_arm", start=START, goal=GOAL))
    motion = result.require().trajectory
    assert apart(result, other, base, start) > 0.0
    assert motion.duration < alone.duration + other.require().trajectory.duration
    if x > 1.5:
        assert np.array_equal(motion.positions, alone.positions), "nothing is in the way"
    speeds = np.abs(motion(np.linspace(0.0, motion.duration, 200), 1)).max(axis=1)
    (moving,) = np.nonzero(speeds > 1e-3)
    assert (speeds[moving[0] : moving[-1]] > 1e-3).all(), "once it moves it does not stop"


def test_the_certificate_lists_the_assumptions(cell: to.Scene, other: to.Result) -> None:
    base = to.placement((1.7, 0.0, 0.0), rpy=(0.0, 0.0, np.pi))
    scene = cell.with_robot_in_motion("left", other, base=base, until=3.0)
    notes = (
        to.plan(to.Problem(scene=scene, group="panda_arm", start=START, goal=GOAL))
        .require()
        .certificate.notes
    )
    (said,) = (note for note in notes if "left/panda_link7 " in note)
    assert "mm of its track until 3 s" in said
