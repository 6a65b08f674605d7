"""A constraint and a cost of your own: a function of the joints, which the optimiser and the judge both call.

Here the elbow of a planar arm stays bent. docs/extending.md shows terms with exact derivatives, and
requirements that are proven at every instant.
"""

import numpy as np

import trajopt as to
from trajopt.optimise.terms import Cost, constraint, residual_from_function
from trajopt.problem.problem import default_costs


def main():
    """Plan with the elbow between 0.2 and 0.5 rad, as near to 0.4 rad as its cost makes it."""
    arm = to.load("planar2")
    bend = residual_from_function("bend of the elbow", lambda positions: positions[1])
    unlike = residual_from_function("elbow away from 0.4 rad", lambda positions: positions[1] - 0.4)
    problem = to.Problem(
        scene=to.Scene(arm),
        start={"joint1": -1.0, "joint2": 0.3},
        goal={"joint1": 1.0, "joint2": 0.3},
        constraints=[constraint(bend, lower=0.2, upper=0.5)],
        costs=[*default_costs(), Cost(unlike, 10.0)],
    )
    plan = to.plan(problem).require()
    print(plan.certificate)  # the own constraint is checked at samples, and the certificate says so
    elbow = plan.trajectory(np.linspace(0.0, plan.trajectory.duration, 200))[:, 1]
    print(f"the elbow is between {elbow.min():.3f} and {elbow.max():.3f} rad")


if __name__ == "__main__":
    main()
