"""Planning, explaining, judging."""

from dataclasses import replace

from trajopt.planning.budget import Budget, Stop
from trajopt.planning.judgement import judge
from trajopt.planning.plan import plan as plan_problem
from trajopt.planning.result import Result, Status
from trajopt.problem.problem import Problem
from trajopt.server.operation import Answer
from trajopt.server.operations.asking import ABOUT, changed, problem_in, trajectory_in
from trajopt.server.operations.words import called, value_of
from trajopt.server.state import SessionState
from trajopt.server.watch import Watch
from trajopt.tasks.cartesian import FollowOptions, follow, follows_curve
from trajopt.values.documents.document import Node
from trajopt.values.errors import ProblemError
from trajopt.why import explain as explain_result

PLANNING = ("method", "seconds", "improve", "every_goal", "free_duration", "certificate")
"""How to plan: the arguments of `plan`, and whether the certificate is wanted."""


def plan(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Plan a problem, or MoveIt's motion plan request.

    The answer is that of `trajopt plan --json`. The clearance takes a few milliseconds to measure, so the
    certificate is included only with `certificate`; `verified` is always included.
    """
    arguments.only((*ABOUT, *PLANNING))
    problem, notes = problem_in(state, arguments)
    result = planned(problem, watch, arguments)
    return Answer(answer_of(result, notes, certificate=arguments["certificate"].flag()))


def answer_of(result: Result, notes: tuple[str, ...] = (), *, certificate: bool = False) -> dict[str, object]:
    """Return a result as plain data.

    Args:
        result: The result.
        notes: Notes on the interpretation of the request.
        certificate: Whether to include the judge's measurements.
    """
    shown = result if certificate else replace(result, judged=None)
    return {**shown.as_dict(), "notes": [*notes, *result.remarks]}


def planned(problem: Problem, watch: Watch, how: Node) -> Result:
    """Plan, and report the progress.

    Args:
        problem: The problem.
        watch: Of the request.
        how: The members named by `PLANNING`, if present.
    """
    seconds, improve = how["seconds"].number(0.0), how["improve"].flag()
    if seconds < 0.0 or (improve and not seconds):
        raise ProblemError("seconds must be positive, and improving takes as many as it is given")
    result = plan_problem(
        problem,
        method=how["method"].text("") or None,
        improve=how["free_duration"].flag(),
        every_goal=how["every_goal"].flag(),
        budget=Budget(seconds or None, improve=improve),
        cancel=watch.cancel,
        progress=watch.progress if watch.heard else None,
        on_incumbent=watch.incumbent if watch.heard else None,
    )
    if result.status is Status.CANCELLED and watch.seconds_left <= 0.0:
        return replace(result, status=Status.OUT_OF_TIME, stopped=Stop.CLOCK)
    return result


def explain(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Plan and explain the outcome; with `plan_again` also remedies."""
    arguments.only((*ABOUT, *PLANNING, "plan_again"))
    problem, notes = problem_in(state, arguments)
    result = planned(problem, watch, arguments)
    found = explain_result(result, plan_again=arguments["plan_again"].flag())
    return Answer({**answer_of(result, notes), "explanation": found.as_dict(), "words": str(found)})


def check(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Judge a trajectory by the requirements of a problem; any one of several goals suffices."""
    arguments.only((*ABOUT, "trajectory"))
    problem, notes = problem_in(state, arguments)
    motion = trajectory_in(arguments["trajectory"]).ordered(problem.reduced.joint_names)
    verdicts = [judge(each, motion) for each in problem.alternatives.values() or (problem,)]
    certificate = next((verdict for verdict in verdicts if verdict.verified), verdicts[0])
    return Answer({**certificate.as_dict(), "words": str(certificate), "notes": list(notes)})


def follow_curve(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Follow a curve with a frame as far as possible: `{"follows_curve": {...}, "options": {...}}`."""
    arguments.only(("edits", "follows_curve", "group", "start", "options", "seconds"))
    state = changed(state, arguments)
    seconds = arguments["seconds"].number(0.0)
    found = follow(
        state.scene,
        called(follows_curve, arguments["follows_curve"]),
        start=value_of(arguments["start"]) if arguments.has("start") else state.positions,
        group=arguments["group"].text(""),
        options=called(FollowOptions, arguments["options"]),
        budget=Budget(seconds or None),
        cancel=watch.cancel,
        progress=watch.progress if watch.heard else None,
    )
    return Answer(found.as_dict())
