"""Methods of planning: a transcription joined with a solver, by name."""

from trajopt.optimise.methods.knots import Knots as Knots
from trajopt.optimise.methods.method import Decoded as Decoded
from trajopt.optimise.methods.method import Method as Method
from trajopt.optimise.methods.method import Program as Program
from trajopt.optimise.methods.method import SupportsEffort as SupportsEffort
from trajopt.optimise.methods.method import SupportsImprovement as SupportsImprovement
from trajopt.optimise.methods.registry import METHODS as METHODS
from trajopt.optimise.methods.registry import Choice as Choice
from trajopt.optimise.methods.registry import choose as choose
from trajopt.optimise.methods.registry import method_named as method_named
from trajopt.optimise.methods.registry import method_names as method_names
from trajopt.optimise.methods.registry import method_of as method_of
from trajopt.optimise.methods.timing import retime_path as retime_path
from trajopt.optimise.methods.timing import stopping_motion as stopping_motion
