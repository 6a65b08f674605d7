"""Methods of planning: a transcription joined with a solver, by name."""

from trajopt.methods.choice import Choice as Choice
from trajopt.methods.choice import choose as choose
from trajopt.methods.knots import Knots as Knots
from trajopt.methods.method import Decoded as Decoded
from trajopt.methods.method import Method as Method
from trajopt.methods.method import Program as Program
from trajopt.methods.method import SupportsEarlyStop as SupportsEarlyStop
from trajopt.methods.method import SupportsImprovement as SupportsImprovement
from trajopt.methods.method import SupportsNearSeeds as SupportsNearSeeds
from trajopt.methods.registry import METHODS as METHODS
from trajopt.methods.registry import method_named as method_named
from trajopt.methods.registry import method_names as method_names
from trajopt.methods.registry import method_of as method_of
from trajopt.methods.stopping import stopping_motion as stopping_motion
from trajopt.methods.timing import retime_path as retime_path
