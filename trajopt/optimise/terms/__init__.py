"""Residuals, one per file, as costs and constraints; each module registers the term of its requirement."""

from trajopt.optimise.terms.clearance import Clearance as Clearance
from trajopt.optimise.terms.clearance import SoftClearance as SoftClearance
from trajopt.optimise.terms.clearance import SoftDistance as SoftDistance
from trajopt.optimise.terms.clearance import soft_clearance as soft_clearance
from trajopt.optimise.terms.joint_positions import RestPosture as RestPosture
from trajopt.optimise.terms.joint_positions import rest_posture as rest_posture
from trajopt.optimise.terms.requirement import Exceeded as Exceeded
from trajopt.optimise.terms.requirement import constrain as constrain
from trajopt.optimise.terms.requirement import penalty as penalty
from trajopt.optimise.terms.singularity_distance import LostManipulability as LostManipulability
from trajopt.optimise.terms.singularity_distance import manipulability as manipulability
from trajopt.optimise.terms.user_functions import Expression as Expression
from trajopt.optimise.terms.user_functions import FunctionResidual as FunctionResidual
from trajopt.optimise.terms.user_functions import residual_from_function as residual_from_function
from trajopt.problem.requirement import import_modules
from trajopt.problem.residual import Constraint as Constraint
from trajopt.problem.residual import Cost as Cost
from trajopt.problem.residual import Residual as Residual
from trajopt.problem.residual import Window as Window
from trajopt.problem.residual import constraint as constraint
from trajopt.problem.smoothness import Acceleration as Acceleration
from trajopt.problem.smoothness import Jerk as Jerk
from trajopt.problem.smoothness import Velocity as Velocity

import_modules(__name__)
