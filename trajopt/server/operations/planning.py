"""Planning, explaining, judging and kinematics, and the problem that a request states."""

from base64 import b64encode
from collections.abc import Mapping
from dataclasses import replace
from typing import TypeVar, cast

from trajopt.files.bundle.containers import message_of
from trajopt.files.moveit.motion_plan_request import request_of
from trajopt.files.moveit.trajectories import read_joint_trajectory, read_points
from trajopt.files.proof import prove
from trajopt.optimise.kinematics import forward_kinematics as place_frame
from trajopt.optimise.kinematics import inverse_kinematics as search_configurations
from trajopt.optimise.kinematics import validity as judge_configuration
from trajopt.planning.budget import Budget, Stop
from trajopt.planning.judgement import judge
from trajopt.planning.plan import plan as plan_problem
from trajopt.planning.result import Result, Status
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import Requirement
from trajopt.problem.stated import only_group
from trajopt.robot.configuration import stated_configuration
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.server.operation import Answer, SessionState, Watch
from trajopt.server.operations.scenes import edited, placement_document
from trajopt.server.operations.words import called, value_of
from trajopt.tasks.cartesian import FollowOptions, follow, follows_curve
from trajopt.tasks.result import TaskResult
from trajopt.tasks.written import task_in
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import PlanningFailed, ProblemError
from trajopt.values.trajectory import Trajectory
from trajopt.why import explain as explain_result

PLANNING = ("method", "seconds", "improve", "every_goal", "free_duration", "certificate", "proof")
"""How to plan: the arguments of `plan`, and whether certificate and proof are requested."""


def plan(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Plan a problem, or MoveIt's motion plan request.

    The answer has the form of `trajopt plan --json`. The certificate is included only with `certificate`;
    `verified` always. With `proof` the answer has the content of a proof file, in base64; null and a note if
    there is none.
    """
    arguments.only((*ABOUT, *PLANNING))
    problem, notes = problem_in(state, arguments)
    result = planned(problem, watch, arguments)
    answer = answer_of(result, notes, certificate=arguments["certificate"].flag())
    return Answer({**answer, **_proven(result, answer)} if arguments["proof"].flag() else answer)


def _proven(result: Result, answer: Mapping[str, object]) -> Mapping[str, object]:
    try:
        plan = result.require()
        proof = prove(plan.problem, plan.trajectory).data
    except (PlanningFailed, ProblemError) as error:
        notes = cast("list[str]", answer["notes"])
        return {"proof": None, "notes": [*notes, f"there is no proof: {error}"]}
    return {"proof": b64encode(proof).decode()}


def answer_of(result: Result, notes: tuple[str, ...] = (), *, certificate: bool = False) -> dict[str, object]:
    """Return a result as plain data."""
    shown = result if certificate else replace(result, judged=None)
    return {**shown.as_dict(), "notes": [*notes, *result.remarks]}


def planned(problem: Problem, watch: Watch, how: Node) -> Result:
    """Plan as the members named by `PLANNING` state, and report the progress."""
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
    return _timed_out(result, watch)


Outcome = TypeVar("Outcome", Result, TaskResult)


def _timed_out(result: Outcome, watch: Watch) -> Outcome:
    if result.status is Status.CANCELLED and watch.seconds_left <= 0.0:
        return replace(result, status=Status.OUT_OF_TIME, stopped=Stop.CLOCK)
    return result


def plan_task(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Plan a task, written as in YAML, from the session's positions unless it has a start.

    With `result` the answer has the whole result in the form of `message_of`.
    """
    arguments.only(("edits", "task", "seconds", "improve", "result"))
    state = changed(state, arguments)
    node, start = without_start(state, arguments["task"])
    planned_task = plan_problem(
        task_in(node, state.scene, start=start),
        improve=arguments["improve"].flag(),
        budget=Budget(arguments["seconds"].number(0.0) or None),
        cancel=watch.cancel,
        progress=watch.progress if watch.heard else None,
    )
    result = _timed_out(planned_task, watch)
    whole = {"result": message_of(result, {"robot": state.scene.robot})}
    return Answer({**result.as_dict(), **(whole if arguments["result"].flag() else {})})


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
        start=without_start(state, arguments)[1],
        group=arguments["group"].text(""),
        options=called(FollowOptions, arguments["options"]),
        budget=Budget(seconds or None),
        cancel=watch.cancel,
        progress=watch.progress if watch.heard else None,
    )
    return Answer(found.as_dict())


WHERE = ("edits", "group", "start")


def _at_start(reduced: ReducedModel) -> Floats:
    return reduced.start[reduced.scene.robot.index(reduced.joint_names)]


def forward_kinematics(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Return placements of frames at one or many configurations of a group; by default of all frames."""
    arguments.only((*WHERE, "frames", "positions", "reference"))
    reduced = reduced_in(state, arguments)
    reference = arguments["reference"].text("world")
    rows = value_of(arguments["positions"]) if arguments.has("positions") else _at_start(reduced)
    names = [node.text() for node in arguments["frames"].elements()] or list(reduced.scene.robot.links)
    found = {name: place_frame(reduced, name, rows, reference=reference) for name in names}
    return Answer(
        {
            "joint_names": list(reduced.joint_names),
            "placements": {
                name: [placement_document(each[i]) for i in range(len(each))] for name, each in found.items()
            },
        }
    )


def inverse_kinematics(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Search configurations that hold a goal: `{"goal": {"frame_placement": {...}}}`."""
    arguments.only((*WHERE, "goal", "near"))
    state = changed(state, arguments)
    stated = {"goal": arguments["goal"].value, "group": arguments["group"].text("")}
    start = {"start": arguments["start"].value} if arguments.has("start") else {}
    document = Node({"problem": {**stated, **start}}, arguments.path)
    problem = problem_in(state, document)[0]
    near = value_of(arguments["near"]) if arguments.has("near") else None
    found = search_configurations(problem.reduced, problem.goals, near=near)
    return Answer(
        {
            "joint_names": list(problem.reduced.joint_names),
            "free": [each.tolist() for each in found.free],
            "colliding": [each.tolist() for each in found.colliding],
            "message": found.explain(),
        }
    )


def validity(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Judge a configuration of a group: collisions, limits, and `requirements`."""
    arguments.only((*WHERE, "positions", "requirements", "margin"))
    reduced = reduced_in(state, arguments)
    positions = value_of(arguments["positions"]) if arguments.has("positions") else _at_start(reduced)
    required: list[Requirement] = value_of(arguments["requirements"]) or []
    margin = arguments["margin"].number(0.0)
    judged = judge_configuration(reduced, positions, requirements=required, margin=margin)
    return Answer({"joint_names": list(reduced.joint_names), **judged.as_dict()})


ABOUT = ("edits", "problem", "request")


def changed(state: SessionState, arguments: Node) -> SessionState:
    return edited(state, arguments["edits"])


def problem_in(state: SessionState, arguments: Node) -> tuple[Problem, tuple[str, ...]]:
    """Return the problem of a request, and notes on its interpretation.

    It is stated by `problem`, in the words of the Python API, or by `request`, MoveIt's message.
    """
    state = changed(state, arguments)
    stated = [key for key in ("problem", "request") if arguments.has(key)]
    if len(stated) != 1:
        raise arguments.error("state the problem once: as `problem`, or as `request` (MoveIt's message)")
    if stated == ["request"]:
        read = request_of(arguments["request"], state.scene, state.named_positions)
        return read.problem(), read.notes
    node = arguments["problem"]
    if node.has("costs") or node.has("scene"):
        raise node.error("the scene is the session's, and costs are not for requests")
    node, start = without_start(state, node)
    # Apart from the rest, as positions of the session are in radians.
    return replace(called(Problem, node, scene=state.scene, start={}), start=start), ()


def reduced_in(state: SessionState, arguments: Node) -> ReducedModel:
    state = changed(state, arguments)
    group = arguments["group"].text("") or only_group(state.scene.robot)
    return reduce_model(state.scene, group, without_start(state, arguments)[1])


def without_start(state: SessionState, node: Node) -> tuple[Node, Floats]:
    """Return a mapping without its start, and the start; joints not named are as in the session."""
    if not node.has("start"):
        return node, state.positions
    start = stated_configuration(
        state.scene.robot,
        "start",
        value_of(node["start"]),
        group=node["group"].text(""),
        degrees=node["degrees"].flag(),
        others=state.positions,
    )
    return replace(node, value={key: node[key].value for key in node.keys() if key != "start"}), start


def trajectory_in(node: Node) -> Trajectory:
    if node.missing:
        raise node.error("is missing")
    return read_joint_trajectory(node) if node.has("joint_trajectory") else read_points(node)


def at_start(state: SessionState, problem: Problem) -> SessionState:
    return replace(state, scene=problem.scene, positions=problem.start_positions)
