"""Proofs that a problem has no solution: what is returned here holds; no proof proves nothing."""

from trajopt.planning.infeasibility.closed_cut import ClosedCut as ClosedCut
from trajopt.planning.infeasibility.closed_cut import closed_cut as closed_cut
from trajopt.planning.infeasibility.exclusion import exclusion as exclusion
from trajopt.planning.infeasibility.goal_box import box_breaks as box_breaks
from trajopt.planning.infeasibility.goal_box import box_collides as box_collides
from trajopt.planning.infeasibility.goal_box import box_overloads as box_overloads
from trajopt.planning.infeasibility.never_apart import NeverApart as NeverApart
from trajopt.planning.infeasibility.never_apart import never_apart as never_apart
from trajopt.planning.infeasibility.reach import out_of_reach as out_of_reach
from trajopt.planning.infeasibility.too_fast import too_fast as too_fast
from trajopt.planning.infeasibility.too_late import too_late as too_late
