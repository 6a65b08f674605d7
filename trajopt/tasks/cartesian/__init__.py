"""Cartesian motion: a frame follows a curve as far as possible."""

from trajopt.problem.requirements import FollowsCurve as FollowsCurve
from trajopt.problem.requirements import follows_curve as follows_curve
from trajopt.tasks.cartesian.curves import arc_about as arc_about
from trajopt.tasks.cartesian.curves import arc_through as arc_through
from trajopt.tasks.cartesian.curves import circle as circle
from trajopt.tasks.cartesian.curves import joined as joined
from trajopt.tasks.cartesian.curves import line as line
from trajopt.tasks.cartesian.curves import polyline as polyline
from trajopt.tasks.cartesian.curves import read_poses as read_poses
from trajopt.tasks.cartesian.curves import spline as spline
from trajopt.tasks.cartesian.execution import Executed as Executed
from trajopt.tasks.cartesian.execution import execute as execute
from trajopt.tasks.cartesian.following import Avoid as Avoid
from trajopt.tasks.cartesian.following import Begin as Begin
from trajopt.tasks.cartesian.following import FollowOptions as FollowOptions
from trajopt.tasks.cartesian.following import follow as follow
from trajopt.tasks.cartesian.raster import raster as raster
from trajopt.tasks.cartesian.result import Followed as Followed
from trajopt.tasks.cartesian.result import StopReason as StopReason
from trajopt.values.curve import Curve as Curve
