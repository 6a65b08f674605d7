"""Kinds of values that a bundle holds, by the names that its files use.

A kind that is not here is not in any bundle; nothing else is ever made of what a file says.
"""

from functools import cache

from trajopt.io.values import Kinds, kinds_in
from trajopt.model.kinds import model_kinds


@cache
def bundle_kinds() -> Kinds:
    """Return the classes by name."""
    return {
        **model_kinds(),
        **kinds_in(
            {
                "trajopt.nlp": "Loss",
                "trajopt.terms.residual": "Cost Constraint Window",
                "trajopt.terms.smoothness": "Velocity Acceleration Jerk",
                "trajopt.terms.rest_posture": "RestPosture",
                "trajopt.terms.singularity_distance": "LostManipulability",
                "trajopt.problem": "Problem",
                "trajopt.planning.budget": "Budget",
            }
        ),
    }
