"""Every term's Jacobian against finite differences: free, near contact and in penetration."""

import importlib
import inspect
import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
import trajopt.terms
from tests.robots_for_tests import odd_arm
from trajopt import terms
from trajopt.arrays import Floats
from trajopt.cartesian import line
from trajopt.model.reduced import ReducedModel, reduce_model
from trajopt.model.requirements import Gaze, RotationCoordinates, follows_curve
from trajopt.model.shapes import Box, Capsule, Cone, Cylinder, Plane, Shape, Sphere, convex
from trajopt.nlp import Rows
from trajopt.query import Query
from trajopt.terms.axis_alignment import AxisAngle
from trajopt.terms.coupled_joints import JointSum
from trajopt.terms.distance_between import PointDistance
from trajopt.terms.expression import Expression
from trajopt.terms.follows_curve import CurveError
from trajopt.terms.frame_placement import FramePlacementError
from trajopt.terms.gaze import ViewAngle, ViewDistance
from trajopt.terms.gravity_torque import GravityShare, HoldingTorque
from trajopt.terms.joint_positions import JointPosition
from trajopt.terms.line_of_sight import SightClearance
from trajopt.terms.motion import Motion
from trajopt.terms.point_on_arc import ArcCoordinates
from trajopt.terms.position_in_region import RegionCoordinates
from trajopt.terms.residual import Residual
from trajopt.terms.singularity_distance import SmallestSingularValue

KNOTS = 4
SHAPES: dict[str, Shape] = {
    "box": Box(0.3, 0.3, 0.3),
    "sphere": Sphere(0.15),
    "cylinder": Cylinder(0.15, 0.4),
    "capsule": Capsule(0.1, 0.2),
    "cone": Cone(0.2, 0.4),
    "plane": Plane(),
    "convex": convex(np.random.default_rng(3).normal(size=(20, 3)) * 0.12),
}


@dataclass(frozen=True, eq=False)
class World:
    reduced: ReducedModel
    query: Query

    def motion(self, knots: Floats) -> Motion:
        return Motion.through(knots, np.full(len(knots) - 1, 3), self.query)


def world(folder: Path, shape: Shape, where: to.Placement) -> World:
    robot = odd_arm(folder)
    scene = to.Scene(robot).add("thing", shape, where)
    scene = scene.add(
        "held",
        Box(0.05, 0.04, 0.1),
        to.placement((0.1, 0.02, 0.05)),
        frame="tip",
        touch_links=["tip", "finger"],
        mass=0.7,
    )
    reduced = reduce_model(scene, "all", robot.positions())
    return World(reduced, Query(reduced))


def frame_error(coordinates: RotationCoordinates, reference: str) -> Callable[[World], Residual]:
    def build(at: World) -> Residual:
        required = to.frame_placement(
            "held",
            to.placement((0.4, 0.1, 0.2), rpy=(0.3, -0.2, 0.5)),
            reference=reference,
            coordinates=coordinates,
            offset=(0.02, -0.01, 0.03),
        )
        return FramePlacementError(at.reduced, required)

    return build


def tilt(reference: str) -> Callable[[World], Residual]:
    def build(at: World) -> Residual:
        required = to.axis_alignment(
            "held", axis=(0.1, 0.2, 1.0), direction=(0.3, 0, 1), tolerance=0.1, reference=reference
        )
        return AxisAngle(at.reduced, required)

    return build


def region(at: World) -> Residual:
    union = [
        (Box(0.2, 0.3, 0.4), to.placement((0.3, 0.1, 0.2), rpy=(0.1, 0.2, 0.3))),
        (Sphere(0.1), to.placement((-0.2, 0.3, 0.4))),
        (Cylinder(0.1, 0.3), to.placement((0.1, -0.3, 0.3), rpy=(0.5, 0, 0))),
        (Plane(), to.placement((0, 0, -0.2), rpy=(0, 0.2, 0))),
    ]
    return RegionCoordinates(
        at.reduced, to.position_in_region("held", union, reference="slide", offset=(0.01, 0.02, 0.03))
    )


def arc(at: World) -> Residual:
    circle = to.placement((0.1, 0.1, 0.2), rpy=(0.1, 0.2, 0.3))
    required = to.point_on_arc("tip", circle, radius=0.2, tolerance=0.01, sweep=2.0, reference="thing")
    return ArcCoordinates(at.reduced, required)


def apart(at: World) -> Residual:
    required = to.distance_between(
        "held", "slide", lower=0.1, upper=0.5, first_offset=(0, 0.1, 0), second_offset=(0, 0, 0.2)
    )
    return PointDistance(at.reduced, required)


def camera(reference: str) -> Gaze:
    return to.gaze(
        "held",
        (0.3, 0.2, 0.1),
        angle=0.3,
        axis=(0.1, 0.2, 1),
        origin=(0, 0, 0.02),
        farthest=1,
        reference=reference,
    )


def away(frame: str, length: float) -> Callable[[World], Residual]:
    def build(at: World) -> Residual:
        required = to.singularity_distance(frame, 0.01, length=length, offset=(0.05, 0, 0.02))
        return SmallestSingularValue(at.reduced, required)

    return build


def near_pair() -> Residual:
    wished = {
        ("tip", "thing"): terms.SoftDistance(2.5, 30.0),
        ("held", "thing"): terms.SoftDistance(2.0, 0.0),
    }
    return terms.soft_clearance(2.0, weight=7.0, pairs=wished).residual


def curve(reference: str, **more: object) -> Callable[[World], Residual]:
    def build(at: World) -> Residual:
        begin = to.placement((0.1, 0.1, 0.2), rpy=(0.1, 0.2, 0.3))
        way = line(begin, to.placement((0.3, -0.2, 0.4), rpy=(1.0, -0.2, 0.3)))
        required = follows_curve("held", way, reference=reference, offset=(0.1, 0, 0), **more)  # type: ignore[arg-type]
        return CurveError(at.reduced, required, np.array((0.0, 0.1, 0.3, way.length)))

    return build


def height(at: World) -> Callable[[Floats], Floats]:
    def tip(positions: Floats) -> Floats:
        return at.reduced.scene.placement_of("tip", at.reduced.all_positions(positions)).translation

    return tip


FACTORIES: dict[type, list[Callable[[World], Residual]]] = {
    terms.Velocity: [lambda _: terms.Velocity()],
    terms.Acceleration: [lambda _: terms.Acceleration()],
    terms.Jerk: [lambda _: terms.Jerk()],
    JointPosition: [lambda _: JointPosition(np.array([2, 0]))],
    FramePlacementError: [
        frame_error(coordinates, reference)
        for coordinates in RotationCoordinates
        for reference in ("world", "thing", "slide")
    ],
    Expression: [lambda _: Expression("tip", lambda k: k.point("tip", (0.1, 0.0, 0.2), "slide"))],
    AxisAngle: [tilt("world"), tilt("slide")],
    RegionCoordinates: [region],
    ArcCoordinates: [arc],
    CurveError: [
        curve("world"),
        curve("slide"),
        curve("slide", spin=(0.1, 0.2, 1.0)),
        curve("thing", rotation_tolerance=np.inf),
    ],
    PointDistance: [apart],
    ViewAngle: [lambda at: ViewAngle(at.reduced, camera("slide"))],
    ViewDistance: [lambda at: ViewDistance(at.reduced, camera("world"))],
    JointSum: [lambda _: JointSum(np.array([0.5, 0.0, -1.0, 2.0]), 0.3)],
    terms.RestPosture: [lambda _: terms.RestPosture({"elbow": 0.3, "pan": -0.2})],
    SmallestSingularValue: [away("held", 0.3), away("finger", 0.3), away("finger", 0.0)],
    terms.LostManipulability: [lambda _: terms.LostManipulability("finger", 0.01, 0.2)],
    GravityShare: [lambda at: GravityShare(at.reduced, np.arange(4))],
    HoldingTorque: [lambda _: HoldingTorque(np.array((80.0, 90.0, 60.0, np.inf)), np.full(4, -np.inf))],
    terms.FunctionResidual: [
        lambda at: terms.residual_from_function("tip", height(at)),
        lambda _: terms.residual_from_function(
            "squares", lambda q: q**2, jacobian=lambda q: np.diag(2.0 * q)
        ),
    ],
    terms.Exceeded: [lambda _: terms.Exceeded(camera("world"))],
    SightClearance: [
        lambda at: SightClearance(
            at.reduced, to.line_of_sight("tip", (0.66, 0.2, 0.4), origin=(0, 0, 0.2), ignore=["held"])
        )
    ],
    terms.SoftClearance: [lambda _: near_pair()],
    terms.Clearance: [lambda at: terms.Clearance(at.reduced, activation=2.0)],
}


def every_term() -> list[type]:
    found: set[type] = set()
    for module in pkgutil.walk_packages(trajopt.terms.__path__, "trajopt.terms."):
        for _, value in inspect.getmembers(importlib.import_module(module.name), inspect.isclass):
            if (
                value.__module__.startswith("trajopt.terms")
                and hasattr(value, "linearise")
                and value is not Residual
            ):
                found.add(value)
    return sorted(found, key=lambda cls: cls.__name__)


def keyed(rows: Rows) -> dict[tuple[int, float], int]:
    return {
        (int(c), round(float(p), 6)): i
        for i, (c, p) in enumerate(zip(rows.component, rows.place, strict=True))
    }


def check(
    residual: Residual, at: World, knots: Floats, rng: np.random.Generator, loose: float
) -> tuple[int, int]:
    """Compare directional derivatives; return how many rows were compared and how many are off."""
    rows = residual.linearise(at.motion(knots))
    assert np.isfinite(rows.jacobian).all()
    compared = off = 0
    step = 1e-5
    for _ in range(3):
        direction = rng.normal(size=knots.shape)
        predicted = np.einsum("mkn,mkn->m", rows.jacobian, direction[rows.knots])
        plus = residual.linearise(at.motion(knots + step * direction))
        minus = residual.linearise(at.motion(knots - step * direction))
        high, low = keyed(plus), keyed(minus)
        for key, row in keyed(rows).items():
            if key in high and key in low:
                numeric = (plus.value[high[key]] - minus.value[low[key]]) / (2 * step)
                compared += 1
                off += abs(numeric - predicted[row]) > loose * (1.0 + abs(numeric))
    return compared, off


def random_knots(at: World, rng: np.random.Generator) -> Floats:
    limits = at.reduced.limits
    lower, upper = np.maximum(limits.lower, -3.0), np.minimum(limits.upper, 3.0)
    return rng.uniform(lower, upper, (KNOTS, len(lower)))


@pytest.mark.parametrize("term", every_term(), ids=lambda cls: cls.__name__)
def test_jacobian(term: type, tmp_path: Path) -> None:
    assert term in FACTORIES, f"{term.__name__} has no factory in this test"
    at = world(tmp_path, Sphere(0.15), to.placement((0.5, 0.1, 0.3)))
    rng = np.random.default_rng(5)
    for build in FACTORIES[term]:
        residual = build(at)
        for _ in range(4):
            compared, off = check(residual, at, random_knots(at, rng), rng, 1e-4)
            assert compared > 0
            # At a change of the nearest features the distance has a kink, and no derivative.
            assert off <= (0.01 * compared if term in (terms.Clearance, terms.SoftClearance) else 0)


@pytest.mark.parametrize("shape", SHAPES, ids=str)
@pytest.mark.parametrize("depth", ["free", "near", "penetrating"])
def test_clearance_jacobian(shape: str, depth: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(11)
    at = world(tmp_path, SHAPES[shape], to.placement((0.55, 0.1, 0.25), rpy=(0.3, 0.5, 0.2)))
    wanted = {"free": (0.05, 1.0), "near": (0.0, 0.05), "penetrating": (-0.3, -1e-3)}[depth]
    compared = off = 0
    for _ in range(60):
        knots = np.repeat(random_knots(at, rng)[:1], KNOTS, axis=0) + 1e-3 * rng.normal(size=(KNOTS, 4))
        residual = terms.Clearance(at.reduced, activation=2.0)
        value = residual.linearise(at.motion(knots)).value + at.reduced.scene.margin
        if ((value > wanted[0]) & (value < wanted[1])).any():
            more, wrong = check(residual, at, knots, rng, 1e-3)
            compared, off = compared + more, off + wrong
        if compared > 400:
            break
    assert compared > 50, f"no {depth} configuration was met"
    assert off <= 0.02 * compared


def test_clearance_sign_against_closed_form(tmp_path: Path) -> None:
    """Ball against ball: distance and slope by hand, apart and in penetration."""
    at = world(tmp_path, Sphere(0.1), to.placement((0.7, 0.0, 0.3)))
    rng = np.random.default_rng(2)
    pairs, bodies = at.reduced.pairs, at.reduced.bodies
    names = [{bodies[a].owner, bodies[b].owner} for a, b in zip(pairs.first, pairs.second, strict=True)]
    pair = names.index({"tip", "thing"})
    seen = {True: 0, False: 0}
    for _ in range(1500):
        positions = random_knots(at, rng)[0]
        motion = Motion.single(positions, at.query)
        tip = at.reduced.scene.placement_of("tip", at.reduced.all_positions(positions))
        expected = float(np.linalg.norm(tip * np.array([0.06, 0, 0]) - [0.7, 0.0, 0.3])) - 0.14
        if expected > 0.3:
            continue
        rows = terms.Clearance(at.reduced, activation=0.5).linearise(motion)
        value = rows.value[list(rows.component).index(pair)] + at.reduced.scene.margin
        assert value == pytest.approx(expected, abs=1e-7)
        seen[expected < 0.0] += 1
    assert min(seen.values()) > 3
