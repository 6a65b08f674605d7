"""Arguments by names of other libraries, and values that are given in the wrong place."""

from dataclasses import replace

import pytest

import trajopt as to
from trajopt.tasks.grasping import pick


@pytest.fixture
def problem() -> to.Problem:
    return to.Problem(scene=to.Scene(robot=to.load("planar2")), start=(0.0, 0.0), goal=(0.5, 0.5))


@pytest.mark.parametrize("name", ["timeout", "time_limit", "allowed_planning_time"])
def test_names_seconds_for_a_timeout(problem: to.Problem, name: str) -> None:
    with pytest.raises(to.errors.UnknownArgument, match=f"plan has no argument {name}: did you mean seconds"):
        to.plan(problem, **{name: 3.0})  # type: ignore[arg-type]


def test_names_the_nearest_argument() -> None:
    with pytest.raises(to.errors.UnknownArgument, match="did you mean quaternion"):
        to.placement((0.0, 0.0, 0.0), quat=(0.0, 0.0, 0.0, 1.0))  # type: ignore[call-arg]
    with pytest.raises(to.errors.UnknownArgument, match="did you mean constraints"):
        to.Problem(scene=to.Scene(robot=to.load("planar2")), constrains=())  # type: ignore[call-arg]


def test_lists_all_arguments_where_none_is_near() -> None:
    with pytest.raises(to.errors.UnknownArgument, match="it has xyz, rpy"):
        to.placement((0.0, 0.0, 0.0), zzz=1)  # type: ignore[call-arg]


def test_names_the_argument_that_has_an_option_of_that_name(problem: to.Problem) -> None:
    with pytest.raises(to.errors.UnknownArgument, match=r"mean budget=Budget\(attempts=\.\.\.\)"):
        to.plan(problem, attempts=3)  # type: ignore[call-arg]
    options = r"pick has no argument tool_speed: did you mean options=GraspingOptions\(tool_speed=\.\.\.\)"
    with pytest.raises(to.errors.UnknownArgument, match=options):
        pick(problem.scene, "cup", tool_speed=to.tool_speed("tool", linear=0.1))  # type: ignore[call-arg]


def test_names_the_transpose_of_a_matrix(problem: to.Problem) -> None:
    matrix = to.placement((0.5, 0.1, 0.0)).homogeneous
    with pytest.raises(to.errors.ShapeError, match=r"goal: .* it is transposed, give matrix\.T"):
        replace(problem, goal=matrix.T)


def test_is_a_type_error_as_for_any_function(problem: to.Problem) -> None:
    with pytest.raises(TypeError):
        to.plan(problem, timeout=3.0)  # type: ignore[call-arg]


def test_names_the_argument_for_a_tool_speed(problem: to.Problem) -> None:
    given = r"it is given as Problem\(tool_speed=\.\.\.\), or GraspingOptions\(tool_speed=\.\.\.\)"
    with pytest.raises(to.errors.ProblemError, match=given):
        to.Problem(
            scene=problem.scene,
            start=(0.0, 0.0),
            goal=(0.5, 0.5),
            constraints=[to.tool_speed("tool", linear=0.1)],  # type: ignore[list-item]
        )


def test_notes_an_object_that_was_added_to_a_copy() -> None:
    scene = to.Scene(robot=to.load("planar2"))
    kept = scene.add("crate", to.Box(0.1, 0.1, 0.1), to.placement((1.0, 1.0, 0.0)))
    lacking = to.Problem(scene=scene, start=(0.0, 0.0), goal=(0.5, 0.5))
    assert "crate: added to a copy of this scene" in str(lacking)
    assert "copy of this scene" not in str(to.Problem(scene=kept, start=(0.0, 0.0), goal=(0.5, 0.5)))
    for number in range(100):
        scene.add(f"box{number}", to.Box(0.1, 0.1, 0.1))
    assert len(str(lacking)) < 1000
    with pytest.raises(to.errors.ObjectNotFound, match="added to a copy of this scene"):
        scene.object("crate")
