"""First guesses of a path."""

from trajopt.seeds.bumps import bumps as bumps
from trajopt.seeds.inverse_kinematics import GoalCandidates as GoalCandidates
from trajopt.seeds.inverse_kinematics import goal_candidates as goal_candidates
from trajopt.seeds.straight import straight_line as straight_line
