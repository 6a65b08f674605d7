"""Solvers of an `Nlp`; they know no robot and no scene."""

from trajopt.solvers.chomp import Chomp as Chomp
from trajopt.solvers.solver import HasBriefForm as HasBriefForm
from trajopt.solvers.solver import HasNearForm as HasNearForm
from trajopt.solvers.solver import Iteration as Iteration
from trajopt.solvers.solver import Solver as Solver
from trajopt.solvers.solver import SolveResult as SolveResult
from trajopt.solvers.solver import SolverStatus as SolverStatus
from trajopt.solvers.solver import SqpStep as SqpStep
from trajopt.solvers.sqp import Sqp as Sqp
from trajopt.solvers.sqp import TrustRegion as TrustRegion
from trajopt.solvers.stomp import Stomp as Stomp
