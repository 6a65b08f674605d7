"""Goals and path constraints as plain data."""

from trajopt.problem.requirement import DEGREES as DEGREES
from trajopt.problem.requirement import MILLIMETRES as MILLIMETRES
from trajopt.problem.requirement import PERCENT as PERCENT
from trajopt.problem.requirement import PLAIN as PLAIN
from trajopt.problem.requirement import RADIANS as RADIANS
from trajopt.problem.requirement import During as During
from trajopt.problem.requirement import Relaxation as Relaxation
from trajopt.problem.requirement import Requirement as Requirement
from trajopt.problem.requirement import ShownUnit as ShownUnit
from trajopt.problem.requirement import during as during
from trajopt.problem.requirements.alternatives import GoalSet as GoalSet
from trajopt.problem.requirements.alternatives import any_of as any_of
from trajopt.problem.requirements.curves import CURVE_POSITION as CURVE_POSITION
from trajopt.problem.requirements.curves import CURVE_ROTATION as CURVE_ROTATION
from trajopt.problem.requirements.curves import FollowsCurve as FollowsCurve
from trajopt.problem.requirements.curves import follows_curve as follows_curve
from trajopt.problem.requirements.distances import DistanceBetween as DistanceBetween
from trajopt.problem.requirements.distances import LineOfSight as LineOfSight
from trajopt.problem.requirements.distances import distance_between as distance_between
from trajopt.problem.requirements.distances import line_of_sight as line_of_sight
from trajopt.problem.requirements.frames import POSITION_TOLERANCE as POSITION_TOLERANCE
from trajopt.problem.requirements.frames import ROTATION_TOLERANCE as ROTATION_TOLERANCE
from trajopt.problem.requirements.frames import AxisAlignment as AxisAlignment
from trajopt.problem.requirements.frames import FramePlacement as FramePlacement
from trajopt.problem.requirements.frames import Gaze as Gaze
from trajopt.problem.requirements.frames import RotationCoordinates as RotationCoordinates
from trajopt.problem.requirements.frames import axis_alignment as axis_alignment
from trajopt.problem.requirements.frames import frame_placement as frame_placement
from trajopt.problem.requirements.frames import gaze as gaze
from trajopt.problem.requirements.joints import JOINT_TOLERANCE as JOINT_TOLERANCE
from trajopt.problem.requirements.joints import CoupledJoints as CoupledJoints
from trajopt.problem.requirements.joints import GravityTorque as GravityTorque
from trajopt.problem.requirements.joints import JointPositions as JointPositions
from trajopt.problem.requirements.joints import SingularityDistance as SingularityDistance
from trajopt.problem.requirements.joints import coupled_joints as coupled_joints
from trajopt.problem.requirements.joints import gravity_torque as gravity_torque
from trajopt.problem.requirements.joints import joint_positions as joint_positions
from trajopt.problem.requirements.joints import singularity_distance as singularity_distance
from trajopt.problem.requirements.joints import together as together
from trajopt.problem.requirements.regions import Member as Member
from trajopt.problem.requirements.regions import PointOnArc as PointOnArc
from trajopt.problem.requirements.regions import PositionInRegion as PositionInRegion
from trajopt.problem.requirements.regions import Region as Region
from trajopt.problem.requirements.regions import point_on_arc as point_on_arc
from trajopt.problem.requirements.regions import point_on_line as point_on_line
from trajopt.problem.requirements.regions import point_on_plane as point_on_plane
from trajopt.problem.requirements.regions import position_in_region as position_in_region
from trajopt.values.placement import WORLD as WORLD

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
