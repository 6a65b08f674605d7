"""compare(): every method gets the same problems, first guesses and judge."""

import json
from collections.abc import Sequence
from dataclasses import dataclass

import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from tests.test_plan import GOAL, START
from trajopt.lab.suite import Allowance, RunOutcome, compared, installed_definitions, run
from trajopt.lab.suite.instance import find_instances, instances_of
from trajopt.optimise.methods import Knots, Program
from trajopt.optimise.solvers import Chomp, Sqp
from trajopt.values.arrays import Floats
from trajopt.values.errors import FileFormatError, MissingExtra, ProblemNotFound, SolverNotFound
from trajopt.values.trajectory import Trajectory


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> to.Problem:
    arm = odd_arm(tmp_path_factory.mktemp("robot"))
    pillar = to.Scene(arm).add("pillar", to.Cylinder(0.08, 1.0), to.placement((0.72, 0.0, 0.3)))
    return to.Problem(scene=pillar, start=START, goal=to.joint_positions(GOAL), name="past a pillar")


@pytest.fixture(scope="module")
def found(problem: to.Problem) -> tuple[RunOutcome, ...]:
    blocked = to.joint_positions({**GOAL, "pan": 0.0})
    refused = to.Problem(scene=problem.scene, start=START, goal=blocked)
    return to.compare(
        {"pillar": problem, "blocked": refused}, ["sqp", "chomp", "sqp-osqp", Knots(Sqp(max_iterations=1))],
        attempts=1,
    )  # fmt: skip


def test_every_problem_by_every_method(found: tuple[RunOutcome, ...]) -> None:
    assert [(item.problem, item.solver) for item in found] == [
        (name, solver) for name in ("pillar", "blocked") for solver in ("sqp", "chomp", "sqp-osqp", "sqp")
    ]


def test_a_run_repeats_the_outcome_of_planning(problem: to.Problem, found: tuple[RunOutcome, ...]) -> None:
    plan = to.plan(problem).require()
    solved = found[0]
    assert solved.verified and solved.good and not solved.violations
    assert solved.duration == plan.trajectory.duration
    assert solved.path_length == plan.path.length
    assert solved.clearance == plan.certificate.clearance
    assert solved.cost == pytest.approx(solved.history[-1].cost)
    assert solved.iterations == len(solved.history) and solved.attempts == solved.history[-1].attempt == 1
    times = [moment.cpu_seconds for moment in solved.history]
    assert times == sorted(times) and 0.0 < times[0] and times[-1] < solved.cpu_seconds


def test_the_tip_goes_where_the_last_joint_goes(problem: to.Problem, found: tuple[RunOutcome, ...]) -> None:
    reduced = problem.reduced
    begin, end = found[0].tip[0], found[0].tip[-1]
    for point, positions in ((begin, START), (end, GOAL)):
        motion = Trajectory(
            reduced.joint_names, [0.0, 1.0], [[positions[name] for name in reduced.joint_names]] * 2
        )
        assert motion.duration == 1.0
        assert (point[0] ** 2 + point[1] ** 2) ** 0.5 == pytest.approx(
            (begin[0] ** 2 + begin[1] ** 2) ** 0.5, abs=1e-3
        )
    assert begin != end


def test_a_failure_names_the_violated_constraint(found: tuple[RunOutcome, ...]) -> None:
    given_up = found[3]
    assert not given_up.good and given_up.status is to.Status.STUCK
    assert given_up.attempts == 1 and given_up.iterations == 1, "one step is not enough"
    assert given_up.violations["clearance"] > 1e-3 and not given_up.tip


def test_unanswerable_problems_are_not_counted(found: tuple[RunOutcome, ...]) -> None:
    assert all(item.status is to.Status.GOAL_IN_COLLISION and not item.askable for item in found[4:])


def test_runs_survive_json(found: tuple[RunOutcome, ...]) -> None:
    for item in found:
        again = RunOutcome.from_dict(json.loads(json.dumps(item.as_dict(), allow_nan=False)))
        assert again == item


@dataclass(frozen=True)
class NotInstalled:
    name: str = "elsewhere"

    def objection(self, problem: to.Problem) -> str:
        return ""

    def program(self, problem: to.Problem, seed: Floats, waypoint_knots: Sequence[int] = ()) -> Program:
        raise MissingExtra("elsewhere", "qp")


def test_a_method_that_is_not_installed_is_named_and_left_out(problem: to.Problem) -> None:
    told: list[str] = []
    done = list(
        compared(
            instances_of([problem]), [NotInstalled(), Knots(Chomp())], Allowance(1),
            skipped=lambda method, error: told.append(f"{method.name}: {error}"),
        )
    )  # fmt: skip
    assert [item.solver for item in done] == ["chomp"]
    assert len(told) == 1 and "pip install" in told[0]
    with pytest.raises(MissingExtra):
        to.compare([problem], [NotInstalled()])


def test_of_a_goal_set_any_goal_will_do(problem: to.Problem) -> None:
    blocked = to.joint_positions({**GOAL, "pan": 0.0})
    either = to.any_of({"blocked": blocked, "free": to.joint_positions(GOAL)})
    asked = to.Problem(scene=problem.scene, start=START, goal=either)
    (instance,) = instances_of({"either": asked})
    assert run(instance, Knots(), budget=Allowance().budget).verified


def test_names() -> None:
    assert [item.name for item in installed_definitions(["planar_fold"])] == ["planar_fold"]
    assert len(installed_definitions()) > 60
    with pytest.raises(ProblemNotFound, match="planar_fold"):
        to.compare(["planar_fould"], ["sqp"])
    with pytest.raises(SolverNotFound, match="chomp"):
        to.compare(["planar_fold"], ["chump"])


def test_files_that_are_not_there(problem: to.Problem, tmp_path_factory: pytest.TempPathFactory) -> None:
    with pytest.raises(FileFormatError):
        find_instances(tmp_path_factory.mktemp("empty"), problem.scene.robot)
