"""What a motion must achieve, as plain data: goals and path constraints, one kind a file.

Each is stated once here. The optimiser's term and the judge's check are computed from it by separate
code, so that one can catch the other's mistakes.
"""

from trajopt.model.requirements.axis_alignment import AxisAlignment as AxisAlignment
from trajopt.model.requirements.axis_alignment import axis_alignment as axis_alignment
from trajopt.model.requirements.coupled_joints import CoupledJoints as CoupledJoints
from trajopt.model.requirements.coupled_joints import coupled_joints as coupled_joints
from trajopt.model.requirements.distance_between import DistanceBetween as DistanceBetween
from trajopt.model.requirements.distance_between import distance_between as distance_between
from trajopt.model.requirements.during import During as During
from trajopt.model.requirements.during import during as during
from trajopt.model.requirements.follows_curve import CURVE_POSITION as CURVE_POSITION
from trajopt.model.requirements.follows_curve import CURVE_ROTATION as CURVE_ROTATION
from trajopt.model.requirements.follows_curve import FollowsCurve as FollowsCurve
from trajopt.model.requirements.follows_curve import follows_curve as follows_curve
from trajopt.model.requirements.frame_placement import POSITION_TOLERANCE as POSITION_TOLERANCE
from trajopt.model.requirements.frame_placement import ROTATION_TOLERANCE as ROTATION_TOLERANCE
from trajopt.model.requirements.frame_placement import FramePlacement as FramePlacement
from trajopt.model.requirements.frame_placement import RotationCoordinates as RotationCoordinates
from trajopt.model.requirements.frame_placement import frame_placement as frame_placement
from trajopt.model.requirements.gaze import Gaze as Gaze
from trajopt.model.requirements.gaze import gaze as gaze
from trajopt.model.requirements.goal_set import GoalSet as GoalSet
from trajopt.model.requirements.goal_set import any_of as any_of
from trajopt.model.requirements.gravity_torque import GravityTorque as GravityTorque
from trajopt.model.requirements.gravity_torque import gravity_torque as gravity_torque
from trajopt.model.requirements.joint_positions import JOINT_TOLERANCE as JOINT_TOLERANCE
from trajopt.model.requirements.joint_positions import JointPositions as JointPositions
from trajopt.model.requirements.joint_positions import joint_positions as joint_positions
from trajopt.model.requirements.joint_positions import together as together
from trajopt.model.requirements.line_of_sight import LineOfSight as LineOfSight
from trajopt.model.requirements.line_of_sight import line_of_sight as line_of_sight
from trajopt.model.requirements.point_on_arc import PointOnArc as PointOnArc
from trajopt.model.requirements.point_on_arc import point_on_arc as point_on_arc
from trajopt.model.requirements.position_in_region import Member as Member
from trajopt.model.requirements.position_in_region import PositionInRegion as PositionInRegion
from trajopt.model.requirements.position_in_region import Region as Region
from trajopt.model.requirements.position_in_region import point_on_line as point_on_line
from trajopt.model.requirements.position_in_region import point_on_plane as point_on_plane
from trajopt.model.requirements.position_in_region import position_in_region as position_in_region
from trajopt.model.requirements.requirement import DEGREES as DEGREES
from trajopt.model.requirements.requirement import MILLIMETRES as MILLIMETRES
from trajopt.model.requirements.requirement import PERCENT as PERCENT
from trajopt.model.requirements.requirement import PLAIN as PLAIN
from trajopt.model.requirements.requirement import RADIANS as RADIANS
from trajopt.model.requirements.requirement import WORLD as WORLD
from trajopt.model.requirements.requirement import Relaxation as Relaxation
from trajopt.model.requirements.requirement import Requirement as Requirement
from trajopt.model.requirements.requirement import ShownUnit as ShownUnit
from trajopt.model.requirements.singularity_distance import SingularityDistance as SingularityDistance
from trajopt.model.requirements.singularity_distance import singularity_distance as singularity_distance

__all__ = [
    "Requirement",
    "RotationCoordinates",
    "any_of",
    "axis_alignment",
    "coupled_joints",
    "distance_between",
    "during",
    "follows_curve",
    "frame_placement",
    "gaze",
    "gravity_torque",
    "joint_positions",
    "line_of_sight",
    "point_on_arc",
    "point_on_line",
    "point_on_plane",
    "position_in_region",
    "singularity_distance",
]
