"""First guesses of a path: one module for each kind of source."""

from trajopt.seeds.around import Around as Around
from trajopt.seeds.bumps import Bumps as Bumps
from trajopt.seeds.conflict import conflicting as conflicting
from trajopt.seeds.inverse_kinematics import MANY_STARTS as MANY_STARTS
from trajopt.seeds.inverse_kinematics import STARTS as STARTS
from trajopt.seeds.inverse_kinematics import GoalCandidates as GoalCandidates
from trajopt.seeds.inverse_kinematics import goal_candidates as goal_candidates
from trajopt.seeds.kind import SeedKind as SeedKind
from trajopt.seeds.sampled import SampledPaths as SampledPaths
from trajopt.seeds.source import Blocked as Blocked
from trajopt.seeds.source import Check as Check
from trajopt.seeds.source import Guess as Guess
from trajopt.seeds.source import NoGuess as NoGuess
from trajopt.seeds.source import Ready as Ready
from trajopt.seeds.source import Route as Route
from trajopt.seeds.source import Source as Source
from trajopt.seeds.straight import straight_line as straight_line
from trajopt.seeds.straight_lines import StraightLines as StraightLines
from trajopt.seeds.waypoints import WaypointLine as WaypointLine
from trajopt.seeds.waypoints import choose_waypoints as choose_waypoints
from trajopt.seeds.waypoints import line_through as line_through
