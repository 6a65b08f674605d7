"""Planning: seeds of many kinds, each optimised, timed and judged, within a budget."""

from trajopt.planning.attempt import plan_once as plan_once
from trajopt.planning.budget import Budget as Budget
from trajopt.planning.budget import BudgetTracker as BudgetTracker
from trajopt.planning.budget import Progress as Progress
from trajopt.planning.budget import Stop as Stop
from trajopt.planning.budget import Stopped as Stopped
from trajopt.planning.judgement import judge as judge
from trajopt.planning.many import PlansProblem as PlansProblem
from trajopt.planning.many import plan_many as plan_many
from trajopt.planning.moving.path_time import PathTime as PathTime
from trajopt.planning.moving.path_time import forbidden_times as forbidden_times
from trajopt.planning.replan import on_the_way as on_the_way
from trajopt.planning.replan import replan as replan
from trajopt.planning.result import Attempt as Attempt
from trajopt.planning.result import Plan as Plan
from trajopt.planning.result import Result as Result
from trajopt.planning.status import Certainty as Certainty
from trajopt.planning.status import Status as Status
from trajopt.planning.workspace import PlanningWorkspace as PlanningWorkspace
