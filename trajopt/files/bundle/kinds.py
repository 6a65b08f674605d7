"""Kinds of values that a bundle holds, by the names that its files use.

A kind that is not here is not in any bundle; nothing else is ever made of what a file says.
"""

from functools import cache

from trajopt.problem.kinds import model_kinds
from trajopt.values.documents.values import Kinds, kinds_in


@cache
def bundle_kinds() -> Kinds:
    """Return the classes by name."""
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
