"""Proofs that a problem has no solution: every returned proof holds; a missing one proves nothing."""

from trajopt.planning.infeasibility.cover import ClosedCut as ClosedCut
from trajopt.planning.infeasibility.cover import NeverApart as NeverApart
from trajopt.planning.infeasibility.cover import box_breaks as box_breaks
from trajopt.planning.infeasibility.cover import box_collides as box_collides
from trajopt.planning.infeasibility.cover import box_overloads as box_overloads
from trajopt.planning.infeasibility.cover import closed_cut as closed_cut
from trajopt.planning.infeasibility.cover import joints_between as joints_between
from trajopt.planning.infeasibility.cover import never_apart as never_apart
from trajopt.planning.infeasibility.exclusion import exclusion as exclusion
from trajopt.planning.infeasibility.inevitable import met_braking as met_braking
from trajopt.planning.infeasibility.joint_bounds import out_of_reach as out_of_reach
from trajopt.planning.infeasibility.joint_bounds import too_fast as too_fast
from trajopt.planning.infeasibility.joint_bounds import too_late as too_late
