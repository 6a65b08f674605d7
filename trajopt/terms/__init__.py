"""Residuals, one per file, as costs and constraints; each module registers the term of its requirement."""

from trajopt.model.requirements.registered import import_modules
from trajopt.terms.clearance import Clearance as Clearance
from trajopt.terms.expression import Expression as Expression
from trajopt.terms.penalty import Exceeded as Exceeded
from trajopt.terms.penalty import penalty as penalty
from trajopt.terms.requirement import constrain as constrain
from trajopt.terms.residual import Constraint as Constraint
from trajopt.terms.residual import Cost as Cost
from trajopt.terms.residual import Residual as Residual
from trajopt.terms.residual import Window as Window
from trajopt.terms.residual import constraint as constraint
from trajopt.terms.residual_from_function import FunctionResidual as FunctionResidual
from trajopt.terms.residual_from_function import residual_from_function as residual_from_function
from trajopt.terms.rest_posture import RestPosture as RestPosture
from trajopt.terms.rest_posture import rest_posture as rest_posture
from trajopt.terms.singularity_distance import LostManipulability as LostManipulability
from trajopt.terms.singularity_distance import manipulability as manipulability
from trajopt.terms.smoothness import Acceleration as Acceleration
from trajopt.terms.smoothness import Jerk as Jerk
from trajopt.terms.smoothness import Velocity as Velocity
from trajopt.terms.soft_clearance import SoftClearance as SoftClearance
from trajopt.terms.soft_clearance import SoftDistance as SoftDistance
from trajopt.terms.soft_clearance import soft_clearance as soft_clearance

import_modules(__name__)
