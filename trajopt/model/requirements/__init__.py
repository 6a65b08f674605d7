"""What a motion must achieve, as plain data: goals and path constraints, one kind a file.

Each is written once here. The optimiser's term and the judge's check are computed from it by code
of their own, so that one can catch the other's mistakes.
"""

from trajopt.model.requirements.axis_alignment import AxisAlignment as AxisAlignment
from trajopt.model.requirements.axis_alignment import axis_alignment as axis_alignment
from trajopt.model.requirements.frame_placement import POSITION_TOLERANCE as POSITION_TOLERANCE
from trajopt.model.requirements.frame_placement import ROTATION_TOLERANCE as ROTATION_TOLERANCE
from trajopt.model.requirements.frame_placement import FramePlacement as FramePlacement
from trajopt.model.requirements.frame_placement import RotationCoordinates as RotationCoordinates
from trajopt.model.requirements.frame_placement import frame_placement as frame_placement
from trajopt.model.requirements.joint_positions import JOINT_TOLERANCE as JOINT_TOLERANCE
from trajopt.model.requirements.joint_positions import JointPositions as JointPositions
from trajopt.model.requirements.joint_positions import joint_positions as joint_positions
from trajopt.model.requirements.requirement import WORLD as WORLD
from trajopt.model.requirements.requirement import Requirement as Requirement
