"""Solvers of an `Nlp`; they know no robot and no scene."""

from trajopt.optimise.solvers.chomp import Chomp as Chomp
from trajopt.optimise.solvers.solver import Effort as Effort
from trajopt.optimise.solvers.solver import HasEfforts as HasEfforts
from trajopt.optimise.solvers.solver import Iteration as Iteration
from trajopt.optimise.solvers.solver import Solver as Solver
from trajopt.optimise.solvers.solver import SolveResult as SolveResult
from trajopt.optimise.solvers.solver import SolverStatus as SolverStatus
from trajopt.optimise.solvers.solver import SqpStep as SqpStep
from trajopt.optimise.solvers.sqp import Sqp as Sqp
from trajopt.optimise.solvers.sqp import TrustRegion as TrustRegion
from trajopt.optimise.solvers.stomp import Stomp as Stomp
