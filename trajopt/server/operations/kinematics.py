"""Kinematics: forward, inverse, and validity of configurations."""

from trajopt.optimise.kinematics import forward_kinematics as place_frame
from trajopt.optimise.kinematics import inverse_kinematics as search_configurations
from trajopt.optimise.kinematics import validity as judge_configuration
from trajopt.problem.requirements import Requirement
from trajopt.scene.reduced import ReducedModel
from trajopt.server.operation import Answer
from trajopt.server.operations.asking import changed, problem_in, reduced_in
from trajopt.server.operations.scenes import placement_document
from trajopt.server.operations.words import value_of
from trajopt.server.state import SessionState
from trajopt.server.watch import Watch
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node

WHERE = ("edits", "group", "start")
"""Members that select the robot's group."""


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
