"""Residuals, one a file; each serves as cost or constraint."""

from trajopt.terms.axis_alignment import AxisAngle as AxisAngle
from trajopt.terms.clearance import Clearance as Clearance
from trajopt.terms.coupled_joints import JointSum as JointSum
from trajopt.terms.distance_between import PointDistance as PointDistance
from trajopt.terms.frame_placement import FramePlacementError as FramePlacementError
from trajopt.terms.gaze import ViewAngle as ViewAngle
from trajopt.terms.gaze import ViewDistance as ViewDistance
from trajopt.terms.gravity_torque import GravityShare as GravityShare
from trajopt.terms.joint_positions import JointPosition as JointPosition
from trajopt.terms.point_on_arc import ArcCoordinates as ArcCoordinates
from trajopt.terms.position_in_region import RegionCoordinates as RegionCoordinates
from trajopt.terms.requirement import constrain as constrain
from trajopt.terms.residual import Constraint as Constraint
from trajopt.terms.residual import Cost as Cost
from trajopt.terms.residual import Residual as Residual
from trajopt.terms.residual import Window as Window
from trajopt.terms.residual import constraint as constraint
from trajopt.terms.rest_posture import RestPosture as RestPosture
from trajopt.terms.rest_posture import rest_posture as rest_posture
from trajopt.terms.singularity_distance import LostManipulability as LostManipulability
from trajopt.terms.singularity_distance import SmallestSingularValue as SmallestSingularValue
from trajopt.terms.singularity_distance import manipulability as manipulability
from trajopt.terms.smoothness import Acceleration as Acceleration
from trajopt.terms.smoothness import Jerk as Jerk
from trajopt.terms.smoothness import Velocity as Velocity
