"""Stands for `moveit_msgs.msg`: the messages that scripts build and read."""

from trajopt.commander.moveit_msgs.msg.constraints import BoundingVolume as BoundingVolume
from trajopt.commander.moveit_msgs.msg.constraints import Constraints as Constraints
from trajopt.commander.moveit_msgs.msg.constraints import JointConstraint as JointConstraint
from trajopt.commander.moveit_msgs.msg.constraints import OrientationConstraint as OrientationConstraint
from trajopt.commander.moveit_msgs.msg.constraints import PositionConstraint as PositionConstraint
from trajopt.commander.moveit_msgs.msg.constraints import TrajectoryConstraints as TrajectoryConstraints
from trajopt.commander.moveit_msgs.msg.constraints import VisibilityConstraint as VisibilityConstraint
from trajopt.commander.moveit_msgs.msg.error_codes import MoveItErrorCodes as MoveItErrorCodes
from trajopt.commander.moveit_msgs.msg.planning import DisplayRobotState as DisplayRobotState
from trajopt.commander.moveit_msgs.msg.planning import DisplayTrajectory as DisplayTrajectory
from trajopt.commander.moveit_msgs.msg.planning import Grasp as Grasp
from trajopt.commander.moveit_msgs.msg.planning import GripperTranslation as GripperTranslation
from trajopt.commander.moveit_msgs.msg.planning import MotionPlanRequest as MotionPlanRequest
from trajopt.commander.moveit_msgs.msg.planning import PlaceLocation as PlaceLocation
from trajopt.commander.moveit_msgs.msg.planning import (
    PlannerInterfaceDescription as PlannerInterfaceDescription,
)
from trajopt.commander.moveit_msgs.msg.planning import RobotTrajectory as RobotTrajectory
from trajopt.commander.moveit_msgs.msg.planning import WorkspaceParameters as WorkspaceParameters
from trajopt.commander.moveit_msgs.msg.planning_scene import AllowedCollisionEntry as AllowedCollisionEntry
from trajopt.commander.moveit_msgs.msg.planning_scene import AllowedCollisionMatrix as AllowedCollisionMatrix
from trajopt.commander.moveit_msgs.msg.planning_scene import (
    AttachedCollisionObject as AttachedCollisionObject,
)
from trajopt.commander.moveit_msgs.msg.planning_scene import CollisionObject as CollisionObject
from trajopt.commander.moveit_msgs.msg.planning_scene import LinkPadding as LinkPadding
from trajopt.commander.moveit_msgs.msg.planning_scene import LinkScale as LinkScale
from trajopt.commander.moveit_msgs.msg.planning_scene import PlanningScene as PlanningScene
from trajopt.commander.moveit_msgs.msg.planning_scene import (
    PlanningSceneComponents as PlanningSceneComponents,
)
from trajopt.commander.moveit_msgs.msg.planning_scene import PlanningSceneWorld as PlanningSceneWorld
from trajopt.commander.moveit_msgs.msg.planning_scene import RobotState as RobotState
