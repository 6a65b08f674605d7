"""The judge on curves: proven where it is true, refused where the tool leaves, skips or goes back."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.optimise.terms.worlds import World
from tests.problem.requirements.kind import Kind
from tests.verify.arms import joint as joint_xml
from tests.verify.arms import link as link_xml
from tests.verify.arms import quintic, reduced, robot
from trajopt.optimise.terms.frame_placement import CurveError
from trajopt.problem.requirements import FollowsCurve
from trajopt.problem.residual import Residual
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.tasks.cartesian import Curve, circle, follows_curve, line, polyline
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError
from trajopt.values.trajectory import Trajectory
from trajopt.verify import Check, Evidence, verify


@pytest.fixture
def gantry(tmp_path: Path) -> ReducedModel:
    """A head that slides in x and y and turns about z: its path is known exactly."""
    arm = robot(
        tmp_path,
        link_xml("base"), link_xml("a"), link_xml("b"), link_xml("head"),
        joint_xml("x", "base", "a", kind="prismatic", axis="1 0 0"),
        joint_xml("y", "a", "b", kind="prismatic", axis="0 1 0"),
        joint_xml("turn", "b", "head", axis="0 0 1"),
    )  # fmt: skip
    return reduced(Scene(arm), [0.0, 0.0, 0.0])


def path_checks(model: ReducedModel, moved: Trajectory, required: FollowsCurve) -> list[Check]:
    found = verify(model, moved, goals=(required,), constraints=(required,)).checks
    return [check for check in found if check.name.startswith("path: curve")]


def at(x: float, y: float, turn: float = 0.0) -> to.Placement:
    return to.placement((x, y, 0.0), rpy=(0.0, 0.0, turn))


CORNER = polyline((at(0, 0), at(1, 0), at(1, 1, 1.0)))


def test_a_corner_is_followed_at_rest(gantry: ReducedModel) -> None:
    moved = quintic(gantry, [[0, 0, 0], [1, 0, 0], [1, 1, 1]], 2.0)
    checks = path_checks(gantry, moved, follows_curve("head", CORNER))
    assert [check.name for check in checks] == ["path: curve position", "path: curve rotation"]
    for check in checks:
        assert check.holds
        assert check.evidence is Evidence.PROVEN
        assert check.value is not None
        assert check.value < 1e-5


def test_deviations_are_measured(gantry: ReducedModel) -> None:
    """The middle of the second side is 2 mm off."""
    moved = quintic(gantry, [[0, 0, 0], [1, 0, 0], [1.002, 0.5, 0.5], [1, 1, 1]], 2.0)
    position, _ = path_checks(gantry, moved, follows_curve("head", CORNER))
    assert not position.holds
    wide = follows_curve("head", CORNER, position_tolerance=2.1e-3, rotation_tolerance=4e-3)
    position, _ = path_checks(gantry, moved, wide)
    assert position.holds
    assert position.value == pytest.approx(2e-3, rel=1e-3)
    narrow = follows_curve("head", CORNER, position_tolerance=1.99e-3, rotation_tolerance=4e-3)
    assert not path_checks(gantry, moved, narrow)[0].holds


@pytest.mark.parametrize(
    "knots",
    [
        [[0, 0, 0], [1, 0, 0], [0.7, 0, 0], [1, 0, 0], [1, 1, 1]],
        [[0, 0, 0], [1, 1, 1]],
        [[0, 0, 0], [1, 0, 0], [1, 0.9, 0.9]],
        [[1, 1, 1], [1, 0, 0], [0, 0, 0]],
        [[0, 0, 0], [1, 0, 0], [1, 1, 0.9]],
    ],
    ids=["back and forth", "the corner cut", "not to the end", "backwards", "turned too little"],
)
def test_motions_off_the_curve_are_refused(gantry: ReducedModel, knots: list[list[float]]) -> None:
    moved = quintic(gantry, knots, 2.0)
    checks = path_checks(gantry, moved, follows_curve("head", CORNER, position_tolerance=1e-2))
    assert not all(check.holds for check in checks)


def test_a_motion_must_end_at_the_required_length_of_the_curve(gantry: ReducedModel) -> None:
    moved = quintic(gantry, [[0, 0, 0], [0.6, 0, 0]], 1.0)
    assert all(check.holds for check in path_checks(gantry, moved, follows_curve("head", CORNER, until=0.6)))
    for until in (0.599, 0.601):
        checks = path_checks(gantry, moved, follows_curve("head", CORNER, until=until))
        assert not all(check.holds for check in checks)


def sampled_motion(model: ReducedModel, positions: Floats, rates: Floats, times: Floats) -> Trajectory:
    return Trajectory(model.joint_names, times, positions, rates)


def turning(model: ReducedModel, way: Curve, spin: float, count: int) -> Trajectory:
    """Once round a circle of 0.3 m about (0.3, 0), at rest at both ends, turning by the way."""
    times = np.linspace(0.0, 2.0, count)
    share, rate = times / 2.0, 0.5
    phase = share**2 * (3.0 - 2.0 * share)
    speed = 6.0 * share * (1.0 - share) * rate
    angle = 2.0 * np.pi * phase
    positions = np.stack((0.3 - 0.3 * np.cos(angle), -0.3 * np.sin(angle), spin * phase), axis=1)
    rates = np.stack(
        (0.3 * np.sin(angle), -0.3 * np.cos(angle), np.full(count, spin / (2.0 * np.pi))), axis=1
    )
    return sampled_motion(model, positions, rates * (2.0 * np.pi * speed)[:, None], times)


def test_a_closed_curve_is_followed_once(gantry: ReducedModel) -> None:
    way = circle(to.placement((0.3, 0, 0), rpy=(0, 0, np.pi)), radius=0.3, rotation=np.eye(3))
    once = turning(gantry, way, 0.0, 80)
    assert all(check.holds for check in path_checks(gantry, once, follows_curve("head", way)))
    back = circle(to.placement((0.3, 0, 0), rpy=(0, 0, np.pi)), radius=0.3, rotation=np.eye(3), sweep=-6.283)
    assert not path_checks(gantry, once, follows_curve("head", back))[0].holds
    standing = quintic(gantry, [[0, 0, 0], [0, 0, 1e-9]], 1.0)
    assert not path_checks(gantry, standing, follows_curve("head", way))[0].holds
    spun = turning(gantry, way, 2.0, 80)
    assert not path_checks(gantry, spun, follows_curve("head", way))[1].holds
    assert all(check.holds for check in path_checks(gantry, spun, follows_curve("head", way, spin=(0, 0, 1))))
    assert not path_checks(gantry, spun, follows_curve("head", way, spin=(1, 0, 0)))[1].holds
    free = path_checks(gantry, spun, follows_curve("head", way, rotation_tolerance=np.inf))
    assert [check.name for check in free] == ["path: curve position"]
    assert free[0].holds


def test_hundreds_of_folds_and_turns_are_followed(gantry: ReducedModel) -> None:
    """More of them than even times of the first estimate; one that is left out is seen."""
    ends = np.array([(1e-3 * (number % 2), 0.0, 0.0) for number in range(1000)])
    folds = polyline([at(*end) for end in ends])
    folded = quintic(gantry, ends, 30.0)
    assert all(check.holds for check in path_checks(gantry, folded, follows_curve("head", folds)))
    fewer = quintic(gantry, ends[:-2], 30.0)
    assert not path_checks(gantry, fewer, follows_curve("head", folds))[0].holds
    times = np.linspace(0.0, 30.0, 12_001)
    rate = 2.0 * np.pi * 400 / 30.0
    positions = 0.01 * np.stack((np.cos(rate * times), np.sin(rate * times), 0.0 * times), axis=1)
    rates = rate * np.stack((-positions[:, 1], positions[:, 0], 0.0 * times), axis=1)
    turned = sampled_motion(gantry, positions, rates, times)
    for turns, holds in ((400, True), (399, False)):
        way = circle(to.placement(), radius=0.01, rotation=np.eye(3), sweep=2.0 * np.pi * turns)
        checks = path_checks(gantry, turned, follows_curve("head", way))
        assert all(check.holds for check in checks) == holds


def test_too_few_points_on_a_circle_are_seen(gantry: ReducedModel) -> None:
    """A cubic through few points leaves the circle between them; only there can that be seen."""
    way = circle(to.placement((0.3, 0, 0), rpy=(0, 0, np.pi)), radius=0.3, rotation=np.eye(3))
    worst: list[float] = []
    for count in (9, 17):
        moved = turning(gantry, way, 0.0, count)
        t = np.linspace(0.0, 2.0, 50001)
        x, y = moved(t).T[:2]
        off = float(np.abs(np.hypot(x - 0.3, y) - 0.3).max())
        worst.append(off)
        for factor, holds in ((1.02, True), (0.98, False)):
            wanted = follows_curve("head", way, position_tolerance=factor * off)
            assert path_checks(gantry, moved, wanted)[0].holds == holds
    assert worst[0] > 5.0 * worst[1]


def test_a_waypoint_on_a_curve(gantry: ReducedModel) -> None:
    """As a waypoint it is met where the frame is somewhere on the curve."""
    moved = quintic(gantry, [[0, -1, 0], [0.5, 1, 0]], 1.0)
    way = line(at(0, 0), at(1, 0))
    on_it = follows_curve("head", way, position_tolerance=2e-3, rotation_tolerance=1e-2)
    (found,) = [
        check
        for check in verify(gantry, moved, goals=(), waypoints={"first": (on_it,)}).checks
        if check.name.startswith("waypoint")
    ]
    assert found.holds
    assert found.time == pytest.approx(0.5, abs=0.01)


def test_bad_input_is_refused() -> None:
    way = line(at(0, 0), at(1, 0))
    for call in (
        lambda: follows_curve("head", "a line"),  # type: ignore[arg-type]
        lambda: follows_curve("head", way, until=1.1),
        lambda: follows_curve("head", way, position_tolerance=0.0),
        lambda: follows_curve("head", way, rotation_tolerance=-1.0),
    ):
        with pytest.raises(ProblemError):
            call()


def curve(reference: str, **more: object) -> Callable[[World], Residual]:
    def build(at: World) -> Residual:
        begin = to.placement((0.1, 0.1, 0.2), rpy=(0.1, 0.2, 0.3))
        way = line(begin, to.placement((0.3, -0.2, 0.4), rpy=(1.0, -0.2, 0.3)))
        required = follows_curve("held", way, reference=reference, offset=(0.1, 0, 0), **more)  # type: ignore[arg-type]
        return CurveError(at.reduced, required, np.array((0.0, 0.1, 0.3, way.length)))

    return build


LINE = polyline([to.placement((0.4, 0, 0.5)), to.placement((0.4, 0.3, 0.5))])
HERE = to.placement((0.4, 0.1, 0.2))
KIND = Kind(
    requirement=FollowsCurve,
    printed=[
        (
            follows_curve("tip", LINE, spin=(0, 0, 1)),
            "tip along a curve of 0.3 m from (0.4, 0, 0.5) m to (0.4, 0.3, 0.5) m, "
            "within 0.1 mm and 0.1 deg, free about z",
        ),
        (
            follows_curve("tip", LINE, until=0.05, rotation_tolerance=np.inf, reference="tray"),
            "tip along the first 50 mm of a curve of 0.3 m from (0.4, 0, 0.5) m to (0.4, 0.3, 0.5) m in "
            "tray, within 0.1 mm",
        ),
    ],
    relaxed=[follows_curve("tip", line(HERE, to.placement((0.5, 0.1, 0.2))), position_tolerance=0.01)],
    residuals={
        CurveError: [
            curve("world"),
            curve("slide"),
            curve("slide", spin=(0.1, 0.2, 1.0)),
            curve("thing", rotation_tolerance=np.inf),
        ]
    },
    calls={
        "follows_curve": {
            "frame": "panda_hand_tcp",
            "curve": LINE,
            "position_tolerance": 1e-3,
            "rotation_tolerance": 0.1,
            "until": 0.1,
            "spin": (0.0, 0.0, 1.0),
            "reference": "world",
            "offset": (0.0, 0.0, 0.1),
        }
    },
    measured=frozenset({CurveError}),
)
