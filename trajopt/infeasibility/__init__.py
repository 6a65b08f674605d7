"""Proofs that a problem has no solution: what is returned here holds; no proof proves nothing."""

from trajopt.infeasibility.closed_cut import ClosedCut as ClosedCut
from trajopt.infeasibility.closed_cut import closed_cut as closed_cut
from trajopt.infeasibility.exclusion import exclusion as exclusion
from trajopt.infeasibility.goal_box import box_breaks as box_breaks
from trajopt.infeasibility.goal_box import box_collides as box_collides
from trajopt.infeasibility.goal_box import box_overloads as box_overloads
from trajopt.infeasibility.never_apart import NeverApart as NeverApart
from trajopt.infeasibility.never_apart import never_apart as never_apart
from trajopt.infeasibility.reach import out_of_reach as out_of_reach
from trajopt.infeasibility.too_fast import too_fast as too_fast
from trajopt.infeasibility.too_late import too_late as too_late
