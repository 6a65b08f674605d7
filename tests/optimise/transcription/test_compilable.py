"""The core takes the same steps as Python, to the last bits, of every program that it takes."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.optimise.solvers.in_python import SqpInPython
from tests.optimise.transcription.both_ways import GOAL, SAME, START, descent_of, program, same
from tests.oracles.query import PlainQuery
from tests.planning.walls import wall, walled_in
from tests.robots_for_tests import odd_arm
from trajopt.geometry import WorkCounts
from trajopt.optimise import terms
from trajopt.optimise.methods import Knots
from trajopt.optimise.methods.bspline import Bspline
from trajopt.optimise.solvers import Iteration, SolveResult, SolverStatus, Sqp, sqp
from trajopt.optimise.solvers.descent import DescentLimits
from trajopt.optimise.transcription.compilable import taper_of
from trajopt.optimise.transcription.margins import ShrunkMargins, TaperedMargins
from trajopt.planning.budget import WORK, Stop
from trajopt.problem.motion import Motion
from trajopt.scene.reduced import BodyPairs
from trajopt.values.arrays import Floats, Ints, Loss, Rows

PROBLEMS = [
    *("cup_past_pillar", "weld_seam_panda", "keep_in_view_panda", "wide_berth", "cup_through_gap_panda"),
    *("heavy_payload_panda", "two_arms_meet", "turn_over_panda"),
    *("pick_and_place_panda", "elbow_kept", "past_column_tiago"),
]
"""Of every kind of term, solved and not, with one arm, two arms and rolling wheels."""
ROUNDED = ["hand_on_plane_panda", "pitch_only"]
"""Their steps pass where Coal's depth of curved shapes jumps by 1e-7 m, and its normal by 1e-4, from one
configuration to the next in the fifteenth digit: so far apart the core's terms of frames are."""


def same_logs(one: SolveResult, other: SolveResult) -> None:
    assert one.status is other.status and len(one.log) == len(other.log)
    for mine, theirs in zip(one.log, other.log, strict=True):
        same(vars(mine), vars(theirs))
    # Of a whole path: a joint that is near zero is rounded no finer than the others that its step depends on.
    np.testing.assert_allclose(one.x, other.x, rtol=0.0, atol=SAME["rtol"] * np.abs(other.x).max())


@pytest.mark.parametrize("name", PROBLEMS)
def test_both_ways_take_the_same_steps(name: str) -> None:
    problem, budget = to.named_problem(name), to.Budget(attempts=2)
    native, python = (
        to.plan(problem, method=Knots(solver), budget=budget) for solver in (Sqp(), SqpInPython())
    )
    assert native.status is python.status and native.counts == python.counts
    assert native.solve is not None and python.solve is not None
    same_logs(native.solve, python.solve)


@pytest.mark.parametrize("name", ROUNDED)
def test_both_ways_take_nearly_the_same_steps(name: str) -> None:
    problem, budget = to.named_problem(name), to.Budget(attempts=2)
    native, python = (
        to.plan(problem, method=Knots(solver), budget=budget) for solver in (Sqp(), SqpInPython())
    )
    assert native.status is python.status and native.solve is not None and python.solve is not None
    assert native.solve.status is python.solve.status and len(native.solve.log) == len(python.solve.log)
    np.testing.assert_allclose(native.solve.x, python.solve.x, atol=1e-4)


@pytest.mark.parametrize("enclosed", [False, True])
def test_where_nothing_is_found_they_end_alike(tmp_path: Path, enclosed: bool) -> None:
    problem = (walled_in if enclosed else wall)(odd_arm(tmp_path))
    seed = program(problem)[0]
    for gives_up in (False, True):
        one, other = (solver(gives_up=gives_up) for solver in (Sqp, SqpInPython))
        found = one.solve(program(problem)[1], seed)
        same_logs(found, other.solve(program(problem)[1], seed))
        assert (found.status is SolverStatus.GIVEN_UP) == gives_up


def test_splines_are_descended_alike(tmp_path: Path) -> None:
    problem = wall(odd_arm(tmp_path))
    seed, _ = program(problem)
    one, other = (
        Bspline(solver=solver).program(problem, seed).solve(seed) for solver in (Sqp(), SqpInPython())
    )
    same_logs(one, other)


def everything(folder: Path, *more: terms.Cost, **changes: object) -> to.Problem:
    """Return a problem with every loss, windows, contacts for a time, and terms of every kind."""
    scene = to.Scene(odd_arm(folder)).add("pillar", to.Cylinder(0.08, 1.0), to.placement((0.72, 0, 0.3)))
    scene = scene.allow_contact("touch", "pillar", "tip", depth=0.01, first=0.3, last=0.2)
    early, late = terms.Window(0.0, 0.4), terms.Window(0.7, 1.0)
    given = {"scene": scene, "start": START, "goal": to.joint_positions(GOAL)}
    clearance = terms.Clearance(to.Problem(**given).reduced)
    asked = {
        "constraints": [
            to.joint_positions({"elbow": 0.3}, tolerance=0.4),
            to.axis_alignment("tip", axis=(1, 0, 0), direction=(1, 0, 0), tolerance=2.5),
            terms.constraint(terms.Jerk(), lower=-0.1, upper=0.1),
            terms.constraint(
                clearance, lower=-0.01, upper=np.linspace(0.1, 0.2, len(clearance.reduced.pairs.margin))
            ),
        ],
        "costs": [
            terms.Cost(terms.Velocity(), 1.0),
            terms.Cost(terms.Acceleration(), 4.0, window=early),
            terms.Cost(terms.Jerk(), 0.3, Loss.ABSOLUTE),
            terms.rest_posture({"elbow": 0.5}, weight=0.2, loss=Loss.HINGE, window=late),
            terms.soft_clearance(0.2, pairs={("tip", "pillar"): terms.SoftDistance(0.4, 7.0)}),
            terms.soft_clearance(0.1, window=early),
            terms.Cost(clearance, 0.1, Loss.ABSOLUTE),
            terms.manipulability("tip", reference=0.01),
            terms.Cost(terms.residual_from_function("warmth", lambda q: q @ q), 0.01, Loss.HINGE),
            *more,
        ],
    }
    return to.Problem(**{**given, **asked, **changes})


@pytest.mark.parametrize("share", [1.0, 0.4])
@pytest.mark.parametrize("fine", [False, True])
def test_every_block_is_as_python_has_it(tmp_path: Path, share: float, fine: bool) -> None:
    problem = everything(tmp_path)
    seed, nlp = program(problem)
    # Each has a query of its own: what one measured would save the other work.
    nlp, other = (each if share == 1.0 else each.keeping(share) for each in (nlp, program(problem)[1]))
    for noise in (0.0, 0.05, 0.3):
        x = seed + np.random.default_rng(3).normal(0.0, noise, seed.shape)
        sampling = nlp.sampling(x, fine=fine)
        run = descent_of(nlp, sampling)
        assert run is not None
        assert (other.sampling(x, fine=fine) == sampling).all()
        run.begin(x, sampling)
        native, python = run.linearised(), other.linearise(x, sampling)
        assert native.feasible == python.feasible == run.feasible
        assert [run.point.cost, run.point.violation] == pytest.approx([python.cost, python.violation])
        assert vars(nlp.counts) == vars(other.counts)
        blocks = (*native.costs, *native.constraints), (*python.costs, *python.constraints)
        assert len(blocks[0]) == 14 and sum(len(block.rows.value) for block in blocks[0]) > 800
        for mine, theirs in zip(*blocks, strict=True):
            same(vars(mine), vars(theirs))


def test_margins_are_those_of_python() -> None:
    rng, count = np.random.default_rng(5), 400
    pairs = BodyPairs(
        first=np.arange(count),
        second=np.arange(count) + count,
        margin=rng.choice([0.0, 0.01, 0.02, 0.3], count),
        required=rng.choice([0.0, 0.005, 0.02], count),
        error=np.zeros(count),
        allowances=(),
        immobile=frozenset(),
    )
    ends = rng.uniform(-0.02, 0.02, (2, count))
    until, since = rng.choice([-1.0, 0.0, 2.5], count), rng.choice([np.inf, 18.0, 23.0], count)
    tapered = TaperedMargins(pairs, 23.0, ends[0], ends[1], until, since, rng.uniform(0.0, 0.01, count))
    pair, place = rng.integers(0, count, 5000), rng.choice(np.linspace(0.0, 23.0, 47), 5000)
    for rule, native in (
        (tapered, taper_of(tapered, 1.0).in_core(pairs.margin)),
        (ShrunkMargins(tapered, 0.16), taper_of(tapered, 0.16).in_core(pairs.margin)),
    ):
        found = [native(one, there) for one, there in zip(pair.tolist(), place.tolist(), strict=True)]
        assert found == pytest.approx(rule(pair, place), rel=1e-15, abs=1e-18)


@dataclass(frozen=True)
class OwnTerm:
    """A term that only its user knows."""

    name = "own"

    def linearise(self, motion: Motion) -> Rows:
        return motion.rows_of_all(
            motion.positions[:, :1],
            np.eye(motion.positions.shape[1])[None, :1].repeat(len(motion.positions), 0),
        )


class OwnMargin:
    """A clearance by place that only its user knows."""

    def __call__(self, pair: Ints, place: Floats) -> Floats:
        return 0.01 + 0.001 * place


class OwnBounds(terms.Constraint):
    """Bounds that only their user knows."""


class OwnVelocity(terms.Velocity):
    """A term of the library, changed."""


def test_terms_unknown_to_the_core_are_left_to_python(tmp_path: Path) -> None:
    problem = everything(tmp_path)
    seed, nlp = program(problem)
    sampling = nlp.sampling(seed, fine=False)
    assert nlp.compiled(sampling) is not None
    clearance = terms.Clearance(problem.reduced, OwnMargin())
    for cost in (terms.Cost(OwnTerm(), 0.1), terms.Cost(OwnVelocity(), 0.1), terms.Cost(clearance, 0.1)):
        _, other = program(everything(tmp_path, cost))
        assert other.compiled(sampling) is None and descent_of(other, sampling) is None
        assert Sqp().solve(other, seed).log
    own = OwnBounds(terms.Jerk(), np.array((-0.2,)), np.array((0.2,)))
    assert program(everything(tmp_path, constraints=[own]))[1].compiled(sampling) is None
    assert (
        sqp.native_descent("osqp", nlp, sampling, DescentLimits(5, 0.0, 0.0), None, Sqp().trust_region, 5.0)
        is None
    )
    nlp.query = PlainQuery(problem.reduced)
    assert nlp.compiled(sampling) is None


@pytest.mark.parametrize("share", [0.1, 0.35, 0.6, 0.95])
def test_work_ends_at_the_same_step(tmp_path: Path, share: float) -> None:
    problem = wall(odd_arm(tmp_path))
    whole = to.plan(problem, method=Knots(SqpInPython()))
    budget = to.Budget(work=int(share * whole.counts[WORK]))
    native, python = (
        to.plan(problem, method=Knots(solver), budget=budget) for solver in (Sqp(), SqpInPython())
    )
    assert native.counts == python.counts and native.stopped is python.stopped is Stop.WORK


def test_progress_is_called_at_every_step_with_the_counts_of_then(tmp_path: Path) -> None:
    problem = everything(tmp_path)
    told: list[list[tuple[Iteration, WorkCounts]]] = []
    for solver in (Sqp(), SqpInPython()):
        seed, nlp = program(problem)
        seen: list[tuple[Iteration, WorkCounts]] = []
        result = solver.solve(
            nlp, seed, progress=lambda step, n=nlp, s=seen: s.append((step, replace(n.counts)))
        )
        assert [step for step, _ in seen] == list(result.log) and len(seen) > 3
        told.append(seen)
    for (one, counts), (other, others) in zip(*told, strict=True):
        same(vars(one), vars(other))
        assert vars(counts) == vars(others)


@dataclass(eq=False)
class PatientList(list[Iteration]):
    """Keeps what it is told, in no hurry."""

    patience: int | None = None

    def __call__(self, iteration: Iteration, /) -> None:
        self.append(iteration)
        if len(self) == self.last:
            raise KeyboardInterrupt

    last: int = 0


def test_a_slow_listener_receives_all_steps_in_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seed, nlp = program(wall(odd_arm(tmp_path)))
    used: list[int] = []
    for seconds in (0.0, 1e6):
        monkeypatch.setattr(sqp, "SILENCE", seconds)
        watch, ended = PatientList(), PatientList(last=1)
        assert list(Sqp().solve(nlp, seed, progress=watch).log) == watch and len(watch) > 3
        before = nlp.counts.forward_kinematics
        with pytest.raises(KeyboardInterrupt):
            Sqp().solve(nlp, seed, progress=ended)
        assert ended == watch[:1]
        used.append(nlp.counts.forward_kinematics - before)
    assert used[0] < used[1], "told at once it ends at once; what is done until it is told counts"


def test_exceptions_of_a_term_are_raised(tmp_path: Path) -> None:
    calls: list[int] = []

    def breaks(q: Floats) -> float:
        calls.append(1)
        if len(calls) > 2000:
            raise ZeroDivisionError("on purpose")
        return float(q @ q)

    function = terms.residual_from_function("breaks", breaks, jacobian=lambda q: 2.0 * q)
    seed, nlp = program(everything(tmp_path, terms.Cost(function, 0.1)))
    with pytest.raises(ZeroDivisionError, match="on purpose"):
        Sqp().solve(nlp, seed)
    assert nlp.counts.forward_kinematics > 0 and nlp.counts.distances > 0
