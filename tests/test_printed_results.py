"""Values print in one line with `repr`, and as a person reads them with `str`: no arrays, no SI digits."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

import trajopt as to
from trajopt.optimise.methods import method_of
from trajopt.planning.budget import BudgetTracker
from trajopt.planning.workspace import PlanningWorkspace
from trajopt.values.arrays import Value
from trajopt.values.printed import in_degrees, in_joint_position, in_range, in_short, in_unit, in_unit_apart

LINE = 260
"""Characters that a person still takes in as one line."""


@pytest.fixture(scope="module")
def result() -> to.Result:
    return to.plan(to.named_problem("cup_past_pillar"))


@pytest.fixture(scope="module")
def values(result: to.Result) -> dict[str, object]:
    problem, plan = result.problem, result.require()
    program = method_of(None).program(problem, plan.path.knots)
    certificate = plan.certificate
    assert result.solve is not None and result.timed is not None
    return {
        "problem": problem,
        "scene": problem.scene,
        "robot": problem.scene.robot,
        "group": problem.scene.robot.group(problem.group),
        "object": problem.scene.add("box", to.Box(1, 1, 1)).object("box"),
        "reduced": problem.reduced,
        "result": result,
        "plan": plan,
        "attempt": result.attempts[0],
        "certificate": certificate,
        "check": certificate.checks[0],
        "pairs": certificate.pairs[0],
        "explanation": result.explain(),
        "trajectory": plan.trajectory,
        "path": plan.path,
        "retimed": result.timed,
        "solve": result.solve,
        "linearisation": result.solve.at,
        "program": program,
        "workspace": PlanningWorkspace(problem, BudgetTracker(to.Budget())),
        "budget": to.Budget(seconds=2.0),
    }


def test_every_value_prints_in_one_line(values: dict[str, object]) -> None:
    for name, value in values.items():
        text = repr(value)
        assert len(text) <= LINE and "\n" not in text and "array(" not in text, f"{name}: {text}"


def test_printing_shows_no_arrays(values: dict[str, object]) -> None:
    for name, value in values.items():
        assert "array(" not in str(value), name


def test_a_printed_result_reports_its_outcome(result: to.Result) -> None:
    plan = result.require()
    assert repr(result).startswith(
        f"Result({result.problem.name!r}, SOLVED, {plan.trajectory.duration:.3f} s"
    )
    lines = str(result).splitlines()
    assert lines[0] == result.reason and lines[-1].strip() == str(result.attempts[-1])
    assert certificate_lines(result)[0] in str(result)
    failed = replace(result, status=to.Status.STUCK, trajectory=None, judged=None, message="no way")
    assert repr(failed) == f"Result({result.problem.name!r}, STUCK, 1 attempt)"
    many = replace(result, attempts=result.attempts * 9)
    assert str(many).splitlines()[-1] == "  and 4 more attempts"


def certificate_lines(result: to.Result) -> list[str]:
    return str(result.require().certificate).splitlines()


def test_a_certificate_is_in_millimetres_and_degrees(result: to.Result) -> None:
    certificate = result.require().certificate
    rows = certificate_lines(result)[3 : 3 + len(certificate.checks)]
    assert not any(f"  {unit} " in row for row in rows for unit in ("m", "rad", "rad/s", "rad/s^2"))
    check = next(item for item in certificate.checks if item.name == "velocity")
    (row,) = (row for row in rows if " velocity " in row)
    assert check.unit == "rad/s" and check.value is not None, "the data stay in SI units"
    assert f"{np.degrees(check.value):.5g}" in row and "deg/s" in row
    assert in_unit(check.value, "rad/s") in repr(check)
    assert str(check).startswith(f"ok: velocity of {check.subject}: ")


@pytest.mark.parametrize(
    ("value", "unit", "said"),
    [
        (0.004, "m", "4 mm"),
        (1.25, "m", "1.25 m"),
        (0.5, "rad", "28.65 deg"),
        (-5e-12, "rad", "0 deg"),
        (-0.5, "rad/s", "-28.65 deg/s"),
        (0.25, "m/s", "250 mm/s"),
        (12.5, "Nm", "12.5 Nm"),
        (0.05, "", "0.05"),
    ],
)
def test_numbers_have_the_units_that_people_speak_in(value: float, unit: str, said: str) -> None:
    assert in_unit(value, unit) == said


def test_rounding_errors_of_angles_print_as_zero() -> None:
    assert in_degrees(-1e-16) == "0 deg"
    assert in_degrees(1e-6) == "5.73e-05 deg"


def test_joint_positions_and_ranges() -> None:
    assert in_joint_position(3.0, "rad") == "171.9 deg (3.0000 rad)"
    assert in_joint_position(0.02, "m") == "20 mm"
    assert in_range(-2.8973, 2.8973, "rad") == "[-166, 166] deg"
    assert in_range(0.0, 0.04, "m") == "[0, 40] mm"


def test_lines_are_cut() -> None:
    assert in_short("a" * 300, 20) == "a" * 17 + "..." and in_short("one\ntwo") == "one"


def nested() -> Iterator[type[Value]]:
    todo = [Value]
    while todo:
        for kind in todo.pop().__subclasses__():
            yield kind
            todo.append(kind)


def test_no_value_prints_as_a_dataclass_does() -> None:
    kinds = set(nested())
    assert len(kinds) > 40
    # What `dataclass` writes is wrapped, so that it does not recurse.
    assert not [kind.__qualname__ for kind in kinds if hasattr(kind.__repr__, "__wrapped__")]


@pytest.mark.parametrize(
    "value,other,unit,said",
    [
        (4.0, 4.0002, "rad/s", ("229.18 deg/s", "229.19 deg/s")),
        (4.0, 5.0, "rad/s", ("229.2 deg/s", "286.5 deg/s")),
        (0.0500001, 0.05, "m", ("50.0001 mm", "50 mm")),
        (150.001, 150.0, "Nm", ("150.001 Nm", "150 Nm")),
        (0.5, 0.5, "", ("0.5", "0.5")),
        (0.5, np.inf, "Nm", ("0.5 Nm", "inf Nm")),
    ],
)
def test_different_numbers_are_printed_differently(
    value: float, other: float, unit: str, said: tuple[str, str]
) -> None:
    assert in_unit_apart(value, other, unit) == said
