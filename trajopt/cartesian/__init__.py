"""Cartesian motion: a frame follows a curve, as far as it goes, and the result says why not farther."""

from trajopt.cartesian.curves import arc_about as arc_about
from trajopt.cartesian.curves import arc_through as arc_through
from trajopt.cartesian.curves import circle as circle
from trajopt.cartesian.curves import joined as joined
from trajopt.cartesian.curves import line as line
from trajopt.cartesian.curves import polyline as polyline
from trajopt.cartesian.curves import spline as spline
from trajopt.cartesian.execution import Executed as Executed
from trajopt.cartesian.execution import execute as execute
from trajopt.cartesian.files import read_poses as read_poses
from trajopt.cartesian.following import Avoid as Avoid
from trajopt.cartesian.following import Begin as Begin
from trajopt.cartesian.following import FollowOptions as FollowOptions
from trajopt.cartesian.following import follow as follow
from trajopt.cartesian.result import Followed as Followed
from trajopt.cartesian.result import StopReason as StopReason
from trajopt.model.curve import Curve as Curve
from trajopt.model.requirements import FollowsCurve as FollowsCurve
from trajopt.model.requirements import follows_curve as follows_curve
