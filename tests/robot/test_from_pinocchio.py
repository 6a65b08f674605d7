"""A robot made of Pinocchio's own models is the robot of the URDF they came from."""

import pickle
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from tests.conftest import PLANAR_ARM, PLANAR_ARM_SRDF
from trajopt import Robot
from trajopt.robot.loading.pinocchio_model import link_placement
from trajopt.values.errors import FrameNotFound, JointNotFound, ModelError, UnsupportedJoint
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Convex, Cylinder, Sphere

# Mimic joints are what Pinocchio's models do not tell: without one, both ways state the same robot.
URDF = PLANAR_ARM.replace('<mimic joint="left_slide"/>', "")


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    urdf, srdf = tmp_path / "arm.urdf", tmp_path / "arm.srdf"
    urdf.write_text(URDF)
    srdf.write_text(PLANAR_ARM_SRDF)
    return urdf, srdf


@pytest.fixture
def model(files: tuple[Path, Path]) -> pin.Model:
    return pin.buildModelFromUrdf(str(files[0]))


@pytest.fixture
def geometry(files: tuple[Path, Path], model: pin.Model) -> pin.GeometryModel:
    return pin.buildGeomFromUrdf(model, str(files[0]), pin.GeometryType.COLLISION)


def assert_same(one: Robot, other: Robot) -> None:
    assert one.joint_names == other.joint_names
    assert one.links == other.links
    assert one.groups == other.groups
    assert one.disabled_pairs == other.disabled_pairs
    for kind in ("lower", "upper", "velocity", "acceleration", "jerk", "effort"):
        np.testing.assert_array_equal(getattr(one.limits, kind), getattr(other.limits, kind), err_msg=kind)
    positions = one.limits.lower + 0.3 * (one.limits.upper - one.limits.lower)
    for link in one.links:
        a, b = link_placement(one.model, link, positions), link_placement(other.model, link, positions)
        np.testing.assert_allclose(a.rotation, b.rotation, atol=1e-12)
        np.testing.assert_allclose(a.translation, b.translation, atol=1e-12)


def test_the_planar_arm_matches_its_urdf_and_plans_the_same(
    files: tuple[Path, Path], model: pin.Model, geometry: pin.GeometryModel
) -> None:
    urdf, srdf = files
    original = Robot.from_urdf(urdf, srdf=srdf)
    robot = Robot.from_pinocchio(model, geometry, srdf=srdf)
    assert_same(robot, original)
    assert robot.name == "planar_arm"
    of_urdf = {body.name: body for body in original.bodies}
    assert {body.name for body in robot.bodies} == set(of_urdf)
    for body in robot.bodies:
        assert body.shape == of_urdf[body.name].shape
        np.testing.assert_allclose(
            body.placement.translation, of_urdf[body.name].placement.translation, atol=1e-12
        )
    goal = {"shoulder": 1.0, "elbow": 0.8}
    results = [
        to.plan(to.Problem(scene=to.Scene(each), group="arm", start="bent", goal=to.joint_positions(goal)))
        for each in (original, robot)
    ]
    assert all(result.verified for result in results)
    a, b = (result.require() for result in results)
    assert a.trajectory.duration == pytest.approx(b.trajectory.duration, abs=1e-6)


def test_the_panda_matches_its_urdf() -> None:
    try:
        panda = to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    folders = [str(folder) for folder in panda.urdf_path.parents if folder.name == "share"]
    own = pin.buildModelFromUrdf(str(panda.urdf_path))
    shapes = pin.buildGeomFromUrdf(
        own, str(panda.urdf_path), pin.GeometryType.COLLISION, package_dirs=folders
    )
    robot = Robot.from_pinocchio(own, shapes, groups={"arm": ("panda_link0", "panda_link8")})
    assert robot.group("arm").joints == panda.joint_names[:7]
    assert robot.links == panda.links
    assert {body.owner for body in robot.bodies} == {body.owner for body in panda.bodies}
    positions = panda.positions({"panda_joint1": 0.4, "panda_joint4": -1.5})
    for link in panda.links:
        np.testing.assert_allclose(
            link_placement(robot.model, link, positions).translation,
            link_placement(panda.model, link, positions).translation,
            atol=1e-12,
        )


def test_without_groups_all_joints_are_one_group_and_nothing_has_a_body(model: pin.Model) -> None:
    robot = Robot.from_pinocchio(model, name="mine")
    assert robot.name == "mine"
    assert robot.group("all").joints == tuple(model.names[1:])
    assert robot.bodies == ()


def test_groups_are_joints_or_a_chain(model: pin.Model) -> None:
    robot = Robot.from_pinocchio(model, groups={"arm": ("base", "hand"), "two": ["elbow", "shoulder"]})
    assert robot.group("arm").joints == robot.group("two").joints == ("shoulder", "elbow")
    assert robot.group("arm").tip == "hand"
    with pytest.raises(JointNotFound, match="shoulder"):
        Robot.from_pinocchio(model, groups={"arm": ["sholder", "elbow"]})
    with pytest.raises(FrameNotFound, match="hand"):
        Robot.from_pinocchio(model, groups={"arm": ("base", "hnad")})
    for wrong in ("shoulder", ()):
        with pytest.raises(ModelError, match="arm"):
            Robot.from_pinocchio(model, groups={"arm": wrong})


def test_the_model_is_copied(model: pin.Model) -> None:
    robot = Robot.from_pinocchio(model)
    model.frames[2].placement = pin.SE3.Random()
    model.lowerPositionLimit = model.lowerPositionLimit - 1.0
    assert robot.model.lowerPositionLimit[0] == -3.0 == robot.limits.lower[0]


def test_it_pickles_as_a_value(model: pin.Model, geometry: pin.GeometryModel) -> None:
    robot = Robot.from_pinocchio(model, geometry)
    again = pickle.loads(pickle.dumps(robot))
    assert_same(again, robot)
    assert [body.shape for body in again.bodies] == [body.shape for body in robot.bodies]


def test_joints_of_many_degrees_of_freedom_are_refused_by_name(files: tuple[Path, Path]) -> None:
    floating = pin.buildModelFromUrdf(str(files[0]), pin.JointModelFreeFlyer())
    with pytest.raises(UnsupportedJoint, match=r"'root_joint'.*without a root joint"):
        Robot.from_pinocchio(floating)
    ball = pin.Model()
    ball.addJoint(0, pin.JointModelSpherical(), pin.SE3.Identity(), "wrist")
    ball.addBodyFrame("hand", 1, pin.SE3.Identity(), 0)
    with pytest.raises(UnsupportedJoint, match=r"'wrist'.*chain"):
        Robot.from_pinocchio(ball)
    with pytest.raises(ModelError, match="no joint"):
        Robot.from_pinocchio(pin.Model())


def test_crossed_limits_are_refused(model: pin.Model) -> None:
    lower = model.lowerPositionLimit.copy()
    lower[1] = 9.0
    model.lowerPositionLimit = lower
    with pytest.raises(ModelError, match="elbow"):
        Robot.from_pinocchio(model)


def _geometry(model: pin.Model, shape: coal.CollisionGeometry) -> pin.GeometryModel:
    shapes = pin.GeometryModel()
    frame = model.getFrameId("hand", pin.FrameType.BODY)
    shapes.addGeometryObject(
        pin.GeometryObject("thing", model.frames[frame].parentJoint, frame, pin.SE3.Identity(), shape)
    )
    return shapes


CORNERS = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)


def _tetrahedron() -> coal.BVHModelOBBRSS:
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(4, 4)
    for a, b, c in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
        mesh.addTriangle(CORNERS[a], CORNERS[b], CORNERS[c])
    mesh.endModel()
    return mesh


def test_each_shape_becomes_the_same_shape(model: pin.Model) -> None:
    for shape, expected in (
        (coal.Box(0.1, 0.2, 0.3), Box(0.1, 0.2, 0.3)),
        (coal.Sphere(0.1), Sphere(0.1)),
        (coal.Cylinder(0.1, 0.3), Cylinder(0.1, 0.3)),
        (coal.Capsule(0.1, 0.3), Capsule(0.1, 0.3)),
        (coal.Cone(0.1, 0.3), Cone(0.1, 0.3)),
    ):
        (body,) = Robot.from_pinocchio(model, _geometry(model, shape)).bodies
        assert body.shape == expected
        # The joint above the hand is the elbow, half a metre behind it: placed in the hand's own frame.
        np.testing.assert_allclose(body.placement.translation, (-0.5, 0, 0), atol=1e-12)
    mesh = _tetrahedron()
    mesh.buildConvexHull(False, "Qt")
    for shape in (_tetrahedron(), mesh.convex):
        (body,) = Robot.from_pinocchio(model, _geometry(model, shape)).bodies
        assert isinstance(body.shape, Convex)
        assert {tuple(v) for v in body.shape.vertices.tolist()} == {tuple(v) for v in CORNERS.tolist()}


def test_a_shape_that_no_link_can_have_is_refused_by_name(model: pin.Model) -> None:
    with pytest.raises(ModelError, match="'thing' is a Ellipsoid"):
        Robot.from_pinocchio(model, _geometry(model, coal.Ellipsoid(0.1, 0.2, 0.3)))
    swept = coal.Sphere(0.1)
    swept.setSweptSphereRadius(0.02)
    with pytest.raises(ModelError, match=r"'thing'.*swept"):
        Robot.from_pinocchio(model, _geometry(model, swept))
