"""Solvers of an `Nlp`; they know no robot and no scene."""

from trajopt.solvers.chomp import Chomp as Chomp
from trajopt.solvers.result import Iteration as Iteration
from trajopt.solvers.result import SolveResult as SolveResult
from trajopt.solvers.result import SolverStatus as SolverStatus
from trajopt.solvers.result import SqpStep as SqpStep
from trajopt.solvers.solver import HasBriefForm as HasBriefForm
from trajopt.solvers.solver import Solver as Solver
from trajopt.solvers.sqp import Sqp as Sqp
from trajopt.solvers.stomp import Stomp as Stomp
from trajopt.solvers.trust_region import TrustRegion as TrustRegion
