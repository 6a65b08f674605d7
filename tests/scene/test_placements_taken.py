"""A placement is taken in any of its forms, wherever one is taken."""

import inspect
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from tests.robots_for_tests import ODD_ARM
from trajopt.optimise import kinematics
from trajopt.robot.robot import FrameAttachment
from trajopt.scene.reducing import reduce_model
from trajopt.tasks import MoveObject, cartesian, grasping
from trajopt.tasks.cartesian import arc_about, arc_through, circle, line, polyline, raster, spline
from trajopt.tasks.grasping import Grasp, Place, pallet
from trajopt.values.curve import Curve
from trajopt.values.errors import ShapeError, SizeError
from trajopt.values.placement import as_placement

WHERE = to.placement((0.1, -0.2, 0.3), rpy=(0.4, -0.5, 0.6))
FARTHER = to.placement((0.5, -0.1, 0.9), rpy=(0.1, 0.2, 0.3))

FORMS: dict[str, Callable[[to.Placement], Any]] = {
    "placement": lambda at: at,
    "SE3": lambda at: pin.SE3(at.rotation, at.translation),
    "matrix": lambda at: at.homogeneous,
    "nested lists": lambda at: at.homogeneous.tolist(),
    "position and quaternion": lambda at: (at.translation, at.quaternion),
    "lists of both": lambda at: [at.translation.tolist(), (2.0 * at.quaternion).tolist()],
}


def ends(curve: Curve) -> np.ndarray:
    return np.stack([curve.placement(0.0).homogeneous, curve.placement(curve.length).homogeneous])


def centre(begin: Any) -> np.ndarray:
    """A point as far from the begin as from FARTHER."""
    return (WHERE.translation + FARTHER.translation) / 2.0 + np.cross(
        FARTHER.translation - WHERE.translation, (0.0, 0.0, 1.0)
    )


def attached(scene: to.Scene, at: Any) -> np.ndarray:
    return scene.attach("box", "fore", placement=at).object("box").placement.homogeneous


def there_of_any(scene: to.Scene, at: Any) -> Any:
    problem = to.Problem(scene=scene, start={}, group="arm", goal=to.any_of({"there": at}))
    return problem.alternatives["there"].goals[0]


def beside(scene: to.Scene, at: Any) -> np.ndarray:
    """The placements of a robot that rests beside, at a time."""
    reduced = reduce_model(scene, "arm", scene.robot.positions())
    joints = reduced.joint_names
    resting = to.Trajectory(joints, np.array((0.0, 1.0)), np.zeros((2, len(joints))))
    beside_it = scene.with_robot_in_motion("left", reduced, resting, base=at).at(0.5).still_at(0.0)
    found = beside_it.objects
    return np.stack([found[name].placement.homogeneous for name in found if name.startswith("left/")])


BALL = to.Sphere(0.1)
SHEET = to.Mesh(np.eye(3), np.array([(0, 1, 2)], dtype=np.int32))
TAKEN: dict[str, Callable[[to.Scene, Any], Any]] = {
    "Scene.add": lambda scene, at: [
        scene.add("new", BALL, at).object("new").placement.homogeneous,
        scene.add("new", [(BALL, at)]).object("new").parts[0][1].homogeneous,
    ],
    "Scene.with_tool": lambda scene, at: (
        scene.with_tool("tip", "fore", at).tools["tip"].placement.homogeneous
    ),
    "any_of": lambda scene, at: there_of_any(scene, at).placement.homogeneous,
    "Scene.move": lambda scene, at: scene.move("box", at).object("box").placement.homogeneous,
    "Scene.attach": attached,
    "Scene.with_robot_in_motion": beside,
    "frame_placement": lambda scene, at: to.frame_placement("arm", at).placement.homogeneous,
    "point_on_arc": lambda scene, at: (
        to.point_on_arc("arm", at, radius=1.0, tolerance=0.1).centre.homogeneous
    ),
    "position_in_region": lambda scene, at: [
        to.position_in_region("arm", BALL, at).members[0][1].homogeneous,
        to.position_in_region("arm", [(BALL, at)]).members[0][1].homogeneous,
    ],
    "FrameAttachment": lambda scene, at: FrameAttachment("arm", at).placement.homogeneous,
    "Grasp": lambda scene, at: Grasp(placement=at, width=0.01, opening=0.02).placement.homogeneous,
    "Place": lambda scene, at: Place(placement=at).placement.homogeneous,
    "line": lambda scene, at: ends(line(at, FARTHER)),
    "polyline": lambda scene, at: ends(polyline([at, FARTHER])),
    "spline": lambda scene, at: ends(spline([at, FARTHER, to.placement()])),
    "arc_through": lambda scene, at: ends(arc_through(at, (0.4, 0.0, 0.5), FARTHER)),
    "arc_about": lambda scene, at: ends(arc_about(at, FARTHER, centre=centre(at))),
    "raster": lambda scene, at: ends(raster(SHEET, 0, 0.1, at=at)[0]),
    "pallet": lambda scene, at: [place.homogeneous for place in pallet(at, (2, 1, 1), (0.1, 0.1, 0.1))],
    "MoveObject": lambda scene, at: MoveObject("box", at).placement.homogeneous,
    "circle": lambda scene, at: ends(circle(at, radius=0.1, rotation=np.eye(3))),
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", TAKEN)
def test_every_form_is_taken(planar_arm: to.Robot, name: str, form: str) -> None:
    scene = to.Scene(planar_arm).add("box", to.Box(0.1, 0.1, 0.1))
    take = TAKEN[name]
    np.testing.assert_allclose(take(scene, FORMS[form](WHERE)), take(scene, WHERE), atol=1e-12)


FRAMES = {"Robot.from_urdf", "Robot.from_pinocchio", "Robot.from_mjcf"}
"""They take tool frames, as pairs of a link and a placement."""


def test_none_is_forgotten() -> None:
    """Every public function whose declared arguments hold a placement takes all its forms, and is above."""
    declared: set[str] = set()
    for module in (to, cartesian, grasping, kinematics):
        for name in dir(module):
            value: object = getattr(module, name)
            if inspect.isfunction(value) and value.__module__.startswith("trajopt"):
                declared |= {value.__name__} & placed(value)
    for kind in (to.Scene, to.Robot):
        for value in vars(kind).values():
            function = getattr(value, "__func__", value)
            if inspect.isfunction(function) and not function.__name__.startswith("_"):
                declared |= placed(function)
    assert declared == {name for name in TAKEN if name[0].islower() or "." in name} | FRAMES


def placed(function: Any) -> set[str]:
    """The function's name, if it takes a placement; fails if it takes one form of it only."""
    hints = [str(hint.annotation) for hint in inspect.signature(function, eval_str=True).parameters.values()]
    taken = any("pinocchio" in hint and "SE3" in hint for hint in hints)
    narrow = [hint for hint in hints if re.search(r"placement\.Placement\b", hint) and "SE3" not in hint]
    assert not narrow, f"{function.__qualname__} takes a Placement only"
    return {function.__qualname__} if taken else set()


@pytest.mark.parametrize(
    ("value", "says"),
    [
        ("here", "a 4x4 matrix or"),
        ((0.5, 0.0, 0.3), "a position alone; placement((0.5, 0.0, 0.3)) is unturned"),
        (3.0, "a 4x4 matrix or"),
        (np.eye(3), "needs shape (4, 4)"),
        (np.diag((1.0, 1.0, 1.0, 2.0)), "last row"),
        (np.diag((1.0, 1.0, -1.0, 1.0)), "right-handed"),
        (((0.0, 0.0), (0.0, 0.0, 0.0, 1.0)), "xyz: needs shape (3,)"),
        (((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)), "has no length"),
        (((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), "quaternion: needs shape"),
        (np.full((4, 4), np.nan), "not finite"),
        ([[1.0]] * 10_000, "needs shape (4, 4)"),
    ],
)
def test_invalid_placements_are_refused(value: Any, says: str) -> None:
    with pytest.raises(ShapeError, match=re.escape(says)) as refused:
        as_placement("where", value)
    assert str(refused.value).startswith("where: ") and len(str(refused.value)) < 400


def test_too_far() -> None:
    with pytest.raises(SizeError, match="farthest"):
        as_placement("where", ((1e7, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))


def test_a_tool_frame_is_a_pair(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    file.write_text(ODD_ARM)
    robot = to.Robot.from_urdf(file, frames={"pen": ("fore", WHERE.homogeneous)})
    other = to.Robot.from_pinocchio(
        pin.buildModelFromUrdf(str(file)), frames={"pen": ("fore", WHERE.homogeneous)}
    )
    assert robot.frame("pen").link == other.frame("pen").link == "fore"
    np.testing.assert_allclose(robot.frame("pen").placement.homogeneous, WHERE.homogeneous)
    with pytest.raises(ShapeError, match="a link and a placement"):
        to.Robot.from_urdf(file, frames={"pen": WHERE})  # type: ignore[dict-item]
