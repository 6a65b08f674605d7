"""Classes of values in bundles and messages, by the names that files use; nothing else is made of a file."""

from functools import cache

from trajopt.problem.file_kinds import model_kinds
from trajopt.values.documents.codec import Kinds, kinds_in

_ASKED = {"trajopt.tasks.grasping.grasp": "Straight Grasp Place", "trajopt.tasks.grasping.gripper": "Gripper"}
_ANSWERED = {
    "trajopt.planning.budget": "Stop",
    "trajopt.planning.status": "Status Certainty",
    "trajopt.planning.result": "Attempt Result",
    "trajopt.planning.seeds.source": "SeedKind",
    "trajopt.planning.infeasibility.reasons": "Obstruction ObstructionKind",
    "trajopt.optimise.solvers.solver": "SolverStatus",
    "trajopt.tasks.cartesian.result": "Followed StopReason",
    "trajopt.tasks.grasping.result": "Stage Segment Refusal PickPlaceResult",
}
_OF_ROBOTS = {"Robot", "CollisionBody", "JointLimits", "LinkGeometry", "MeshReference"}
"""Parts of robots: a request names a robot and does not contain one."""


@cache
def bundle_kinds() -> Kinds:
    """Return the classes of bundles: of problems and of the arguments of planning."""
    return {
        **model_kinds(),
        **kinds_in(
            {
                "trajopt.optimise.nlp": "Loss",
                "trajopt.problem.residual": "Cost Constraint Window",
                "trajopt.problem.smoothness": "Velocity Acceleration Jerk",
                "trajopt.optimise.terms.joint_positions": "RestPosture",
                "trajopt.optimise.terms.singularity_distance": "LostManipulability",
                "trajopt.problem.problem": "Problem",
                "trajopt.planning.budget": "Budget",
            }
        ),
    }


@cache
def request_kinds() -> Kinds:
    """Return the classes of requests to a server: of bundles without robots, and grasps and places."""
    there = {name: kind for name, kind in bundle_kinds().items() if name not in _OF_ROBOTS}
    return {**there, **kinds_in(_ASKED)}


@cache
def all_kinds() -> Kinds:
    """Return the classes of answers of a server: robots, and results of all kinds."""
    return {**bundle_kinds(), **kinds_in({**_ASKED, **_ANSWERED})}
