"""Tasks: whole jobs of stages, curves that a tool follows, and picking and placing."""

from trajopt.tasks.any_order import AnyOrder as AnyOrder
from trajopt.tasks.grasping.stages import PickObject as PickObject
from trajopt.tasks.grasping.stages import PlaceObject as PlaceObject
from trajopt.tasks.grasping.stages import SetGripper as SetGripper
from trajopt.tasks.result import StageRefusal as StageRefusal
from trajopt.tasks.result import TaskResult as TaskResult
from trajopt.tasks.result import TaskSegment as TaskSegment
from trajopt.tasks.search import TaskStage as TaskStage
from trajopt.tasks.sequence import StageTime as StageTime
from trajopt.tasks.stages import AttachObject as AttachObject
from trajopt.tasks.stages import DetachObject as DetachObject
from trajopt.tasks.stages import Dwell as Dwell
from trajopt.tasks.stages import Fallback as Fallback
from trajopt.tasks.stages import FollowCurve as FollowCurve
from trajopt.tasks.stages import ForEach as ForEach
from trajopt.tasks.stages import MoveObject as MoveObject
from trajopt.tasks.stages import MoveTo as MoveTo
from trajopt.tasks.stages import OneOf as OneOf
from trajopt.tasks.stages import StageCost as StageCost
from trajopt.tasks.stages import StageLimits as StageLimits
from trajopt.tasks.stages import Within as Within
from trajopt.tasks.stages import duration as duration
from trajopt.tasks.stages import joint_travel as joint_travel
from trajopt.tasks.stages import least_clearance as least_clearance
from trajopt.tasks.task import Task as Task
from trajopt.tasks.written import read_task as read_task
