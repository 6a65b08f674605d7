"""The kinds of values that a bundle can hold, by their names in files.

No other class is ever instantiated from the content of a file.
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
