"""The whole line as one program: all knots at once, held on the curve, short, smooth and clear.

A step of differential kinematics freezes the choice that a redundant arm has; here it is made with the whole
line in view. With a tube the curve is a wish inside of it, and what the knots are off it is paid for.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from trajopt.arrays import Floats
from trajopt.cartesian.tracking import Track
from trajopt.model.requirements import FollowsCurve
from trajopt.nlp import Rows
from trajopt.problem import Problem
from trajopt.solvers import SolveResult, Sqp
from trajopt.terms import Constraint, Cost, constraint
from trajopt.terms.follows_curve import POSITION_ROWS, CurveError, within
from trajopt.terms.motion import Motion
from trajopt.transcription import transcribe

SPACING = 0.02
"""Distance of knots along the curve [m]."""
FEWEST, MOST = 16, 96
"""Knots at least and at most."""
HELD = 0.5
"""Share of the tolerances that knots may use: they are moved on to the curve afterwards."""
ROOM = 0.9
"""Share of the tube that knots may use."""
END = 0.01
"""Share of the tube that the last knot may be off: it is moved on to the curve afterwards."""
NEARNESS = 1000.0
"""Weight of squared distances from the curve inside a tube [1/m^2]."""


@dataclass(frozen=True, eq=False)
class Offset:
    """Distance of knots from the curve, along three axes [m]: what a tube's motion pays for.

    Attributes:
        error: The whole error.
    """

    error: CurveError

    @property
    def name(self) -> str:
        """What is paid for."""
        return f"distance from the {self.error.name}"

    def linearise(self, motion: Motion) -> Rows:
        """Evaluate and differentiate at the knots."""
        rows = self.error.linearise(motion)
        keep = rows.component < POSITION_ROWS - 1
        return Rows(
            rows.value[keep], rows.jacobian[keep], rows.knots[keep], rows.component[keep], rows.place[keep]
        )


def knot_stations(required: FollowsCurve) -> Floats:
    """Return where along the curve the program's knots are: even, the joints of its pieces among them."""
    count = int(np.clip(np.ceil(required.until / SPACING), FEWEST, MOST))
    even = np.linspace(0.0, required.until, count + 1)
    for edge in required.curve.edges[1:-1]:
        if edge < required.until:
            even[1 + int(np.abs(even[1:-1] - edge).argmin())] = edge
    return np.unique(even)


def on_the_curve(problem: Problem, required: FollowsCurve, seed: Track) -> SolveResult:
    """Plan the whole line on the curve, from a first seed.

    Args:
        problem: Start, scene and limits.
        required: The curve.
        seed: Its first seed, at the stations that `knot_stations` tells.
    """
    error = CurveError(problem.reduced, required, seed.stations)
    bound = within(required, HELD)
    smallest = HELD * min(required.position_tolerance, required.rotation_tolerance)
    held = constraint(error, lower=-bound, upper=bound, tolerance=0.5 * smallest)
    return _solve(problem, (held,), problem.costs or (), seed)


def in_a_tube(problem: Problem, required: FollowsCurve, tube: float, seed: Track) -> SolveResult:
    """Plan the whole line inside a tube around the curve, as near to the curve as may be.

    Args:
        problem: Start, scene and limits.
        required: The curve.
        tube: Radius of the tube [m].
        seed: The first seed, at the stations that `knot_stations` tells.
    """
    error = CurveError(problem.reduced, required, seed.stations)
    bound = within(required, HELD)
    bound[:POSITION_ROWS] = np.inf
    bound[POSITION_ROWS - 1] = ROOM * tube
    smallest = min(0.02 * tube, 0.25 * required.rotation_tolerance)
    held = constraint(error, lower=-bound, upper=bound, tolerance=smallest)
    costs = (*(problem.costs or ()), Cost(Offset(error), weight=NEARNESS))
    end = replace(required, position_tolerance=max(END * tube, required.position_tolerance))
    return _solve(replace(problem, goal=end), (held,), costs, seed)


def _solve(problem: Problem, held: tuple[Constraint, ...], costs: Sequence[Cost], seed: Track) -> SolveResult:
    asked = replace(
        problem, constraints=(*problem.constraints, *held), costs=tuple(costs), knots=len(seed.stations)
    )
    return Sqp().solve(transcribe(asked, seed.positions), seed.positions)
