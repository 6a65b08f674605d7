"""First guesses of a path."""

from trajopt.seeds.bumps import bumps as bumps
from trajopt.seeds.conflict import conflicting as conflicting
from trajopt.seeds.inverse_kinematics import GoalCandidates as GoalCandidates
from trajopt.seeds.inverse_kinematics import goal_candidates as goal_candidates
from trajopt.seeds.kind import SeedKind as SeedKind
from trajopt.seeds.straight import straight_line as straight_line
from trajopt.seeds.waypoints import WaypointLine as WaypointLine
from trajopt.seeds.waypoints import choose_waypoints as choose_waypoints
from trajopt.seeds.waypoints import line_through as line_through
