"""Degrees for radians and millimetres for metres: what is taken, warned of, and asked back."""

import inspect
import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trajopt as to
from trajopt.tasks.cartesian import circle, follows_curve, line
from trajopt.tasks.grasping import Place
from trajopt.values.errors import UnitWarning
from trajopt.values.likely_units import meant_at_distance, meant_at_speed, meant_in_joint
from trajopt.values.printed import in_direction

AT = to.placement((0.4, 0.0, 0.5))
NEXT = to.placement((0.4, 0.1, 0.5))
TURNED = np.eye(3)

IN_DEGREES: dict[str, tuple[Callable[..., Any], Callable[[Any], Any]]] = {
    "placement": (lambda a, **k: to.placement(rpy=(0, 0, a), **k), lambda made: made.rpy[2]),
    "joint_positions": (lambda a, **k: to.joint_positions({"j": a}, **k), lambda made: made.positions["j"]),
    "tolerance of joints": (
        lambda a, **k: to.joint_positions({"j": 0.0}, tolerance=a, **k), lambda made: made.below["j"],
    ),
    "frame_placement": (
        lambda a, **k: to.frame_placement("f", AT, rotation_tolerance=a, **k),
        lambda made: made.rotation_tolerance[1],
    ),
    "follows_curve": (
        lambda a, **k: follows_curve("f", line(AT, NEXT), rotation_tolerance=a, **k),
        lambda made: made.rotation_tolerance,
    ),
    "axis_alignment": (lambda a, **k: to.axis_alignment("f", tolerance=a, **k), lambda made: made.tolerance),
    "gaze": (lambda a, **k: to.gaze("f", (1, 0, 0), angle=a, **k), lambda made: made.angle),
    "point_on_arc": (
        lambda a, **k: to.point_on_arc("f", AT, radius=0.1, tolerance=0.01, sweep=a, **k),
        lambda made: made.sweep,
    ),
    "circle": (
        lambda a, **k: circle(AT, radius=0.1, rotation=TURNED, sweep=a, **k),
        lambda made: made.pieces[0].sweep,
    ),
    "tool_speed": (lambda a, **k: to.tool_speed("f", angular=a, **k), lambda made: made.angular),
    "planar_base": (
        lambda a, **k: to.bases.planar_base(
            (-1, -1), (1, 1), velocity=(1, a), acceleration=(1, a), yaw=(-a, a), **k
        ),
        lambda made: (made.joints[2].upper + made.joints[2].velocity + made.joints[2].acceleration) / 3.0,
    ),
    "Place": (
        lambda a, **k: Place(placement=AT, rotation_tolerance=a, **k),
        lambda made: made.rotation_tolerance[0],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", IN_DEGREES)
def test_angles_are_taken_in_degrees(name: str) -> None:
    make, angle = IN_DEGREES[name]
    assert angle(make(57.0, degrees=True)) == pytest.approx(np.deg2rad(57.0))
    assert angle(make(0.4)) == pytest.approx(0.4)
    assert angle(make(0.4, degrees=False)) == pytest.approx(0.4)
    with pytest.raises(to.TrajoptError, match=r"degrees must be (a bool|true or false), is 'yes'"):
        make(0.4, degrees="yes")


def test_defaults_in_degrees_do_not_change() -> None:
    for make in (
        lambda **k: to.frame_placement("f", AT, **k).rotation_tolerance.tolist(),
        lambda **k: follows_curve("f", line(AT, NEXT), **k).rotation_tolerance,
        lambda **k: to.point_on_arc("f", AT, radius=0.1, tolerance=0.01, **k).sweep,
        lambda **k: circle(AT, radius=0.1, rotation=TURNED, **k).length,
        lambda **k: to.joint_positions({"j": 0.0}, **k).below,
        lambda **k: Place(placement=AT, **k).rotation_tolerance,
    ):
        np.testing.assert_equal(make(degrees=True), make())


def test_every_function_of_the_short_way_that_takes_angles_takes_degrees() -> None:
    """By its documentation: what has an argument in radians has one that says so of degrees."""
    for name, function in vars(to).items():
        if not inspect.isfunction(function) or name in {"plan_once", "examine", "coupled_joints"}:
            continue  # positions of joints as arrays, and weights of sums
        arguments = (inspect.getdoc(function) or "").partition("Args:")[2].partition("Returns:")[0]
        if "[rad" in arguments.partition("Raises:")[0]:
            assert "degrees" in inspect.signature(function).parameters, name


@pytest.mark.parametrize("angle", [180.0, -90, 6.4])
def test_an_orientation_beyond_a_whole_turn_is_warned_of(angle: float) -> None:
    with pytest.warns(UnitWarning, match=r"rpy is \(.* rad, beyond a whole turn: were degrees meant") as said:
        made = to.placement(rpy=(angle, 0, 0))
    assert said[0].filename == __file__, "the line of the caller"
    assert made.rpy[0] == pytest.approx(np.angle(np.exp(1j * angle)))


def test_whole_turns_and_degrees_are_not_warned_of() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        to.placement(rpy=(2.0 * np.pi, -6.2832, 0))
        to.placement(rpy=(360.0, 0, 720.0), degrees=True)
        to.frame_placement("f", AT, rotation_tolerance=(0.1, 0.1, np.inf))
    with pytest.warns(UnitWarning, match="^rotation_tolerance is"):
        to.frame_placement("f", AT, rotation_tolerance=10)


@pytest.mark.parametrize("kind", ["value", "world", "carried", "robot"])
def test_a_clearance_of_metres_is_warned_of(planar_arm: to.Robot, kind: str) -> None:
    with pytest.warns(UnitWarning, match=rf"{kind} is 20 m: were millimetres meant\? .*: 0.02") as said:
        to.Scene(planar_arm).with_clearance(**{kind: 20})
    assert said[0].filename == __file__, "the line of the caller"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        to.Scene(planar_arm).with_clearance(**{kind: 1.5})


@pytest.mark.parametrize(
    ("value", "lower", "upper", "unit", "meant"),
    [
        (90.0, -2.9, 2.9, "rad", "degrees"),
        (-170.0, -3.0, 3.0, "rad", "degrees"),
        (9.0, -2.9, 2.9, "rad", ""),  # within a turn of the limits: wound, or a little too far
        (200.0, -2.9, 2.9, "rad", ""),  # outside in degrees too
        (20.0, 0.0, 0.04, "m", "millimetres"),
        (0.05, 0.0, 0.04, "m", ""),
        (1.0, 0.0, 0.04, "m", ""),  # a metre is as likely as a millimetre
        (900.0, -1.0, 1.0, "m", "millimetres"),
        (5.0, -1.0, 1.0, "m", ""),
    ],
)
def test_the_suggested_joint_value_is_valid(
    value: float, lower: float, upper: float, unit: str, meant: str
) -> None:
    words = meant_in_joint("j", value, lower, upper, unit)
    assert (f"were {meant} meant? j at {value:g}" in words) if meant else words == ""


def test_the_suggested_distance_and_speed_are_valid() -> None:
    assert "millimetres" in meant_at_distance(400.0, 0.9)
    assert meant_at_distance(3.0, 0.9) == "" == meant_at_distance(5000.0, 0.9)
    assert "degrees" in meant_at_speed(90.0, 2.2, "rad/s") and "millimetres" in meant_at_speed(
        250, 0.6, "m/s"
    )
    assert meant_at_speed(3.0, 2.2, "rad/s") == ""


def test_objects_far_away_are_warned_of() -> None:
    scene = to.Scene(to.load("planar2"))
    with pytest.warns(UnitWarning, match=r"placement of 'cup' is \(400, 0, 300\) m: were millimetres meant"):
        scene = scene.add("cup", to.Sphere(0.03), to.placement((400, 0, 300)))
    with pytest.warns(UnitWarning, match="'cup'"):
        scene.move("cup", to.placement((400, 0, 0)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene.move("cup", to.placement((20, 0, 40)))


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: to.frame_placement("f", AT, position_tolerance=2), "position_tolerance is 2 m"),
        (
            lambda: to.frame_placement("f", AT, position_tolerance=(0.01, 5, np.inf)),
            "position_tolerance is 5 m",
        ),
        (lambda: Place(placement=AT, position_tolerance=2), "position_tolerance is 2 m"),
        (lambda: follows_curve("f", line(AT, NEXT), position_tolerance=2.5), "position_tolerance is 2.5 m"),
        (lambda: to.tool_speed("f", linear=250), "linear speed of 'f' is 250 m/s"),
        (lambda: to.tool_speed("f", angular=90), "angular speed of 'f' is 90 rad/s"),
    ],
)
def test_tolerances_and_speeds_that_ask_nothing_of_an_arm_are_warned_of(
    make: Callable[[], object], said: str
) -> None:
    with pytest.warns(UnitWarning, match=f"^{re.escape(said)}: were (millimetres|degrees) meant") as warned:
        make()
    assert len(warned) == 1


def test_tolerances_and_speeds_that_ask_something_are_not_warned_of() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        to.frame_placement("f", AT, position_tolerance=(0.9, np.inf, np.inf))
        to.tool_speed("f", linear=3.0, angular=12.0)
        to.tool_speed("f", angular=360, degrees=True)


@pytest.mark.parametrize("shape", [to.Sphere(30), to.Box(30, 40, 50), to.Cylinder(radius=30, length=40)])
def test_deep_penetration_suggests_millimetres(shape: to.Box | to.Sphere | to.Cylinder) -> None:
    arm = to.load("ur5")
    scene = to.Scene(arm).add("part", shape, to.placement((0.5, 0, 0.2)))
    for start, goal in (({}, {"elbow_joint": 1.0}), ({"elbow_joint": 1.0}, AT)):
        reason = to.plan(to.Problem(scene=scene, group="manipulator", start=start, goal=goal)).reason
        assert "were millimetres meant? Lengths are in metres" in reason and " m inside part" in reason


def test_shallow_penetration_of_a_large_object_suggests_nothing() -> None:
    wall = to.Scene(to.load("ur5")).add("wall", to.Box(0.2, 40, 40), to.placement((0.6, 0, 0)))
    reason = to.plan(to.Problem(scene=wall, group="manipulator", start={}, goal={"elbow_joint": 1.0})).reason
    assert " mm inside wall" in reason and "meant" not in reason


@pytest.mark.parametrize(
    ("goal", "said"),
    [
        ([0.0] * 5, "goal must be a requirement or several, the name of a state"),
        (np.zeros(5), "positions of the group's joints or of all joints"),
        ((0.4, 0.0, 0.3), "a position alone; placement((x, y, z)) has the identity orientation"),
    ],
)
def test_error_for_a_numeric_goal_lists_the_accepted_forms(goal: Any, said: str) -> None:
    with pytest.raises(to.TrajoptError, match=re.escape(said)):
        to.Problem(scene=to.Scene(to.load("ur5")), group="manipulator", start={}, goal=goal)


@pytest.mark.parametrize(
    ("direction", "reference", "words"),
    [
        ((0, 0, 1), "world", "up"),
        ((0, 0, -1), "world", "down"),
        ((0, 0, -1), "cup", "along -z of cup"),
        ((-1, 0, 0), "world", "along -x"),
        ((0.6, 0, -0.8), "world", "along (0.6, 0, -0.8), 53.1 deg down"),
        ((0.6, 0.8, 0), "world", "along (0.6, 0.8, 0)"),
        ((0.6, 0.8, 0), "cup", "along (0.6, 0.8, 0) of cup"),
    ],
)
def test_directions_in_words(direction: tuple[float, ...], reference: str, words: str) -> None:
    assert in_direction(np.array(direction, dtype=float), reference) == words


def test_a_printed_problem_describes_the_directions_of_the_goal_axes() -> None:
    scene = to.Scene(to.load("panda"))

    def printed(goal: Any) -> str:
        return str(to.Problem(scene=scene, group="panda_arm", start="ready", goal=goal))

    for_down, w_first = (0.0, 1.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
    assert "its z points down, its x along -x" in printed((AT.translation, for_down))
    assert "its z points down, its x along x" in printed((AT.translation, w_first))
    free = to.frame_placement("panda_hand", AT, rotation_tolerance=np.inf)
    assert "points" not in printed(free)


def test_notes_a_mesh_in_millimetres(planar_arm: to.Robot) -> None:
    corners = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
    faces = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
    with pytest.warns(UnitWarning, match=r"'part' is 500 m wide.*scale=0\.001"):
        to.Scene(planar_arm).add("part", to.Mesh(500.0 * corners, faces))
    with pytest.warns(UnitWarning, match="'part' is 500 m wide"):
        to.Scene(planar_arm).add("part", [(to.Mesh(500.0 * corners, faces), to.placement((0, 0, 1)))])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        to.Scene(planar_arm).add("hall", to.Mesh(19.0 * corners, faces))


def test_one_factor_scales_a_mesh_file(tmp_path: Path) -> None:
    file = tmp_path / "part.obj"
    file.write_text("v 0 0 0\nv 500 0 0\nv 0 500 0\nf 1 2 3\n")
    assert float(np.ptp(to.load_mesh(file, 0.001).vertices, axis=0).max()) == pytest.approx(0.5)
