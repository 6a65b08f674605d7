"""Tasks: whole jobs of stages, curves that a tool follows, and picking and placing."""

from trajopt.tasks.jobs.any_order import AnyOrder as AnyOrder
from trajopt.tasks.jobs.result import StageRefusal as StageRefusal
from trajopt.tasks.jobs.result import StageTime as StageTime
from trajopt.tasks.jobs.result import TaskResult as TaskResult
from trajopt.tasks.jobs.result import TaskSegment as TaskSegment
from trajopt.tasks.jobs.search import TaskStage as TaskStage
from trajopt.tasks.jobs.stages import AttachObject as AttachObject
from trajopt.tasks.jobs.stages import DetachObject as DetachObject
from trajopt.tasks.jobs.stages import Dwell as Dwell
from trajopt.tasks.jobs.stages import Fallback as Fallback
from trajopt.tasks.jobs.stages import FollowCurve as FollowCurve
from trajopt.tasks.jobs.stages import MoveObject as MoveObject
from trajopt.tasks.jobs.stages import MoveTo as MoveTo
from trajopt.tasks.jobs.stages import OneOf as OneOf
from trajopt.tasks.jobs.stages import PickObject as PickObject
from trajopt.tasks.jobs.stages import PlaceObject as PlaceObject
from trajopt.tasks.jobs.stages import SetGripper as SetGripper
from trajopt.tasks.jobs.stages import duration as duration
from trajopt.tasks.jobs.stages import joint_travel as joint_travel
from trajopt.tasks.jobs.task import Task as Task
from trajopt.tasks.jobs.written import read_task as read_task
