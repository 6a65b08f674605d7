"""Messages of `moveit_msgs`: planning messages, services and actions of MoveIt."""

from trajopt.files.messages.moveit_msgs.actions import ExecuteTrajectoryFeedback as ExecuteTrajectoryFeedback
from trajopt.files.messages.moveit_msgs.actions import ExecuteTrajectoryGoal as ExecuteTrajectoryGoal
from trajopt.files.messages.moveit_msgs.actions import ExecuteTrajectoryResult as ExecuteTrajectoryResult
from trajopt.files.messages.moveit_msgs.actions import MoveGroupFeedback as MoveGroupFeedback
from trajopt.files.messages.moveit_msgs.actions import MoveGroupGoal as MoveGroupGoal
from trajopt.files.messages.moveit_msgs.actions import MoveGroupResult as MoveGroupResult
from trajopt.files.messages.moveit_msgs.actions import PlanningOptions as PlanningOptions
from trajopt.files.messages.moveit_msgs.constraints import BoundingVolume as BoundingVolume
from trajopt.files.messages.moveit_msgs.constraints import Constraints as Constraints
from trajopt.files.messages.moveit_msgs.constraints import JointConstraint as JointConstraint
from trajopt.files.messages.moveit_msgs.constraints import OrientationConstraint as OrientationConstraint
from trajopt.files.messages.moveit_msgs.constraints import PositionConstraint as PositionConstraint
from trajopt.files.messages.moveit_msgs.constraints import TrajectoryConstraints as TrajectoryConstraints
from trajopt.files.messages.moveit_msgs.constraints import VisibilityConstraint as VisibilityConstraint
from trajopt.files.messages.moveit_msgs.error_codes import MoveItErrorCodes as MoveItErrorCodes
from trajopt.files.messages.moveit_msgs.kinematics import ConstraintEvalResult as ConstraintEvalResult
from trajopt.files.messages.moveit_msgs.kinematics import ContactInformation as ContactInformation
from trajopt.files.messages.moveit_msgs.kinematics import CostSource as CostSource
from trajopt.files.messages.moveit_msgs.kinematics import PositionIKRequest as PositionIKRequest
from trajopt.files.messages.moveit_msgs.planning import CartesianPoint as CartesianPoint
from trajopt.files.messages.moveit_msgs.planning import CartesianTrajectory as CartesianTrajectory
from trajopt.files.messages.moveit_msgs.planning import CartesianTrajectoryPoint as CartesianTrajectoryPoint
from trajopt.files.messages.moveit_msgs.planning import DisplayRobotState as DisplayRobotState
from trajopt.files.messages.moveit_msgs.planning import DisplayTrajectory as DisplayTrajectory
from trajopt.files.messages.moveit_msgs.planning import GenericTrajectory as GenericTrajectory
from trajopt.files.messages.moveit_msgs.planning import Grasp as Grasp
from trajopt.files.messages.moveit_msgs.planning import GripperTranslation as GripperTranslation
from trajopt.files.messages.moveit_msgs.planning import MotionPlanRequest as MotionPlanRequest
from trajopt.files.messages.moveit_msgs.planning import MotionPlanResponse as MotionPlanResponse
from trajopt.files.messages.moveit_msgs.planning import PlaceLocation as PlaceLocation
from trajopt.files.messages.moveit_msgs.planning import (
    PlannerInterfaceDescription as PlannerInterfaceDescription,
)
from trajopt.files.messages.moveit_msgs.planning import RobotTrajectory as RobotTrajectory
from trajopt.files.messages.moveit_msgs.planning import WorkspaceParameters as WorkspaceParameters
from trajopt.files.messages.moveit_msgs.planning_scene import AllowedCollisionEntry as AllowedCollisionEntry
from trajopt.files.messages.moveit_msgs.planning_scene import AllowedCollisionMatrix as AllowedCollisionMatrix
from trajopt.files.messages.moveit_msgs.planning_scene import (
    AttachedCollisionObject as AttachedCollisionObject,
)
from trajopt.files.messages.moveit_msgs.planning_scene import CollisionObject as CollisionObject
from trajopt.files.messages.moveit_msgs.planning_scene import LinkPadding as LinkPadding
from trajopt.files.messages.moveit_msgs.planning_scene import LinkScale as LinkScale
from trajopt.files.messages.moveit_msgs.planning_scene import ObjectColor as ObjectColor
from trajopt.files.messages.moveit_msgs.planning_scene import PlanningScene as PlanningScene
from trajopt.files.messages.moveit_msgs.planning_scene import (
    PlanningSceneComponents as PlanningSceneComponents,
)
from trajopt.files.messages.moveit_msgs.planning_scene import PlanningSceneWorld as PlanningSceneWorld
from trajopt.files.messages.moveit_msgs.planning_scene import RobotState as RobotState
from trajopt.files.messages.moveit_msgs.services import ApplyPlanningSceneRequest as ApplyPlanningSceneRequest
from trajopt.files.messages.moveit_msgs.services import (
    ApplyPlanningSceneResponse as ApplyPlanningSceneResponse,
)
from trajopt.files.messages.moveit_msgs.services import GetCartesianPathRequest as GetCartesianPathRequest
from trajopt.files.messages.moveit_msgs.services import GetCartesianPathResponse as GetCartesianPathResponse
from trajopt.files.messages.moveit_msgs.services import GetMotionPlanRequest as GetMotionPlanRequest
from trajopt.files.messages.moveit_msgs.services import GetMotionPlanResponse as GetMotionPlanResponse
from trajopt.files.messages.moveit_msgs.services import GetPlanningSceneRequest as GetPlanningSceneRequest
from trajopt.files.messages.moveit_msgs.services import GetPlanningSceneResponse as GetPlanningSceneResponse
from trajopt.files.messages.moveit_msgs.services import GetPositionFKRequest as GetPositionFKRequest
from trajopt.files.messages.moveit_msgs.services import GetPositionFKResponse as GetPositionFKResponse
from trajopt.files.messages.moveit_msgs.services import GetPositionIKRequest as GetPositionIKRequest
from trajopt.files.messages.moveit_msgs.services import GetPositionIKResponse as GetPositionIKResponse
from trajopt.files.messages.moveit_msgs.services import GetStateValidityRequest as GetStateValidityRequest
from trajopt.files.messages.moveit_msgs.services import GetStateValidityResponse as GetStateValidityResponse
from trajopt.files.messages.moveit_msgs.services import (
    QueryPlannerInterfacesRequest as QueryPlannerInterfacesRequest,
)
from trajopt.files.messages.moveit_msgs.services import (
    QueryPlannerInterfacesResponse as QueryPlannerInterfacesResponse,
)
