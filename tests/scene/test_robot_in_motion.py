"""Another robot's motion as tracks, against pinocchio's kinematics at many times."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.track import Prediction
from trajopt.values.errors import DuplicateObject, ProblemError, ShapeError
from trajopt.values.shapes.shapes import bounding_box

BASE = to.placement((0.9, -0.3, 0.2), rpy=(0.1, -0.2, 2.5))
SAMPLES = 700


@pytest.fixture(scope="module")
def other(tmp_path_factory: pytest.TempPathFactory) -> ReducedModel:
    """Return an arm with joints that turn and slide, and one that mimics another, which holds a cup."""
    robot = odd_arm(tmp_path_factory.mktemp("robot"))
    scene = to.Scene(robot).add("cup", to.Cylinder(0.04, 0.1), to.placement((0.0, 0.05, 0.1)), frame="tip")
    scene = scene.add("table", to.Box(1.0, 1.0, 0.1), to.placement((0.0, 0.0, -1.0)))
    return reduce_model(scene, "all", np.zeros(len(robot.joint_names)))


def swing(reduced: ReducedModel, seed: int, kind: str) -> to.Trajectory:
    rng, size = np.random.default_rng(seed), len(reduced.joint_names)
    points = np.stack((reduced.start_positions, *rng.uniform(-0.8, 0.8, (2, size))))
    rest = np.zeros((3, size))
    rates = {"linear": (), "cubic": (rest,), "quintic": (rest, rest.copy())}[kind]
    return to.Trajectory(reduced.joint_names, np.array((0.0, 0.7, 1.5)), points, *rates)


def points_of(reduced: ReducedModel, name: str) -> tuple[int, np.ndarray]:
    """Return the joint of a link or object, and the corners of its bodies' boxes in that joint's frame."""
    found, joint = [], 0
    for body in reduced.bodies:
        if body.owner == name:
            joint = body.joint
            for bits in np.ndindex(2, 2, 2):
                box = bounding_box(body.shape)
                corner = np.array([box[bit][axis] for axis, bit in enumerate(bits)])
                found.append(body.placement * corner)
    return joint, np.array(found)


def off(
    reduced: ReducedModel, motion: to.Trajectory, scene: to.Scene, name: str, start: float
) -> tuple[float, float]:
    """Return how far the points of a link get from where the scene has them, and the error that it states."""
    joint, corners = points_of(reduced, name)
    item = scene.objects[f"other/{name}"]
    carrier = item if item.frame == "world" else scene.objects[item.frame]
    known, data, worst = carrier.timing.motion, reduced.model.createData(), 0.0
    rest = reduced.anchors[name].placement.inverse()
    for time in np.linspace(-0.2, motion.duration + 0.2, SAMPLES).tolist():
        pin.forwardKinematics(reduced.model, data, reduced.configuration(motion(time)))
        where = carrier.placement if known is None else known.track.at(time + start)
        where = where if carrier is item else where * item.placement
        there = BASE * to.Placement(data.oMi[joint].rotation, data.oMi[joint].translation)
        for corner in corners:
            worst = max(worst, float(np.linalg.norm(there * corner - where * (rest * corner))))
    return worst, 0.0 if known is None else known.error[0]


@pytest.mark.parametrize("kind", ["linear", "cubic", "quintic"])
@pytest.mark.parametrize("seed", [0, 1])
def test_no_point_is_farther_from_its_track_than_its_error(other: ReducedModel, kind: str, seed: int) -> None:
    motion = swing(other, seed, kind)
    scene = to.Scene(other.scene.robot).with_robot_in_motion(
        "other", other, motion, base=BASE, start=0.4, tolerance=3e-3
    )
    names = {body.owner for body in other.bodies} - {"table"}
    assert set(scene.objects) == {f"other/{name}" for name in names}
    seen = [off(other, motion, scene, name, 0.4) for name in sorted(names)]
    assert all(worst <= error + 1e-7 for worst, error in seen)
    assert all(error <= 3e-3 for _, error in seen)
    assert max(worst for worst, _ in seen) > 5e-4, "pieces that are no longer than need be"


def test_a_tighter_tolerance_has_more_pieces_and_less_error(other: ReducedModel) -> None:
    motion = swing(other, 0, "quintic")
    coarse, fine = (
        to.Track.of(other, "tip", trajectory=motion, reach=0.2, tolerance=size) for size in (5e-3, 1e-4)
    )
    assert isinstance(coarse, Prediction) and isinstance(fine, Prediction)
    assert fine.error[0] <= 1e-4 < coarse.error[0] <= 5e-3
    assert len(coarse.track.times) < len(fine.track.times)
    data = other.model.createData()
    joint, place = other.attachment("tip")
    for time in np.linspace(0.0, 1.5, 200).tolist():
        pin.forwardKinematics(other.model, data, other.configuration(motion(time)))
        there = to.Placement(data.oMi[joint].rotation, data.oMi[joint].translation) * place
        assert np.linalg.norm(there.translation - fine.track.at(time).translation) <= fine.error[0]


def test_static_objects_stay_at_rest(other: ReducedModel) -> None:
    positions = np.tile(other.start_positions, (2, 1))
    motion = to.Trajectory(other.joint_names, np.array((0.0, 1.0)), positions)
    scene = to.Scene(other.scene.robot).with_robot_in_motion("other", other, motion)
    for item in scene.objects.values():
        assert item.timing.motion is None or not item.timing.motion.track.rates.any()
        where = other.scene.placement_of(item.name.removeprefix("other/"), other.start)
        assert scene.placement_of(item.name, other.start).translation == pytest.approx(
            where.translation, abs=1e-9
        )


def test_impossible_motions_are_refused_by_name(other: ReducedModel) -> None:
    scene, motion = to.Scene(other.scene.robot), swing(other, 0, "quintic")
    with pytest.raises(ProblemError, match="give a plan, or a trajectory with the reduced model"):
        scene.with_robot_in_motion("other", other)
    with pytest.raises(ShapeError, match="tolerance: must be positive"):
        scene.with_robot_in_motion("other", other, motion, tolerance=0.0)
    with pytest.raises(ShapeError, match="reach: must be positive, is -1 m"):
        to.Track.of(other, "tip", trajectory=motion, reach=-1.0)
    with pytest.raises(to.TrajoptError, match="'tpi'"):
        to.Track.of(other, "tpi", trajectory=motion, reach=0.1)
    with pytest.raises(DuplicateObject, match="other/"):
        scene.with_robot_in_motion("other", other, motion).with_robot_in_motion("other", other, motion)
    assert not scene.objects, "a refused edit leaves nothing"


def test_an_object_is_carried_by_a_moving_frame(other: ReducedModel) -> None:
    start = other.start
    scene = (
        to.Scene(other.scene.robot)
        .add("belt", to.Box(1.0, 0.2, 0.02), motion=to.Track.constant_velocity(BASE, (0.1, 0.0, 0.0)))
        .add("tray", to.Box(0.2, 0.2, 0.02), to.placement((1.0, 0.0, 0.5)))
    )
    for carried in (
        scene.attach("tray", "belt", at=start),
        scene.attach("tray", "belt", placement=BASE.inverse() * to.placement((1.0, 0.0, 0.5))),
    ):
        assert carried.carrier("tray") == "belt" and carried.changing == ("belt", "tray")
        assert carried.placement_of("tray", start).translation == pytest.approx((1.0, 0.0, 0.5))
        later = carried.at(2.0)
        assert later.placement_of("tray", start).translation == pytest.approx((1.2, 0.0, 0.5))
        left = later.detach("tray", at=start)
        assert left.changing == ("belt",)
        assert left.placement_of("tray", start).translation == pytest.approx((1.2, 0.0, 0.5))
    assert replace(scene).changing == ("belt",)
    with pytest.raises(to.TrajoptError, match="not attached"):
        scene.detach("belt", at=start)
    with pytest.raises(to.TrajoptError, match="is fixed in the world: nothing attached to it would move"):
        scene.attach("belt", "tray", at=start)


CONVEYOR = """<robot name="conveyor"><link name="frame"/><link name="belt"/>
<joint name="drive" type="{kind}"><parent link="frame"/><child link="belt"/><axis xyz="0.6 0 0.8"/>
<limit lower="0" upper="2" velocity="1" effort="10"/></joint></robot>"""


@pytest.mark.parametrize("kind", ["prismatic", "revolute"])
def test_a_robot_of_one_joint_is_one_too(tmp_path: Path, kind: str) -> None:
    (tmp_path / "conveyor.urdf").write_text(CONVEYOR.format(kind=kind))
    (tmp_path / "conveyor.srdf").write_text(
        '<robot name="conveyor"><group name="all"><joint name="drive"/></group></robot>'
    )
    robot = to.load(tmp_path / "conveyor.urdf", srdf=tmp_path / "conveyor.srdf")
    reduced = reduce_model(to.Scene(robot), "all", np.zeros(1))
    motion = swing(reduced, 3, "quintic")
    found = to.Track.of(reduced, "belt", reach=0.3, trajectory=motion)
    for time in np.linspace(0.0, motion.duration, 50):
        at = reduced.scene.placement_of("belt", motion(time))
        apart = at.inverse() * found.track.at(float(time))
        turned = 2.0 * np.sin(np.linalg.norm(pin.log3(apart.rotation)) / 2.0)
        assert np.linalg.norm(apart.translation) + 0.3 * turned <= found.error[0] + 1e-9
