"""An odd arm that holds something near an object, and motions of it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import trajopt as to
import trajopt.optimise.terms
from tests.robots_for_tests import odd_arm
from trajopt.geometry import Contacts, Query
from trajopt.problem.motion import Motion
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats
from trajopt.values.shapes.shapes import Box, Shape

KNOTS = 4


class ExactQuery(Query):
    """Measures all distances: their finite differences are compared with Jacobians."""

    def close_pairs(self, positions: Floats, reach: Floats, aim: Floats | None = None) -> Contacts:
        del aim
        return super().close_pairs(positions, reach)


@dataclass(frozen=True, eq=False)
class World:
    reduced: ReducedModel
    query: Query

    def motion(self, knots: Floats) -> Motion:
        return Motion.through(knots, np.full(len(knots) - 1, 3), self.query)


def world(folder: Path, shape: Shape, where: to.Placement) -> World:
    robot = odd_arm(folder)
    scene = to.Scene(robot).add("thing", shape, where)
    scene = scene.add(
        "held",
        Box(0.05, 0.04, 0.1),
        to.placement((0.1, 0.02, 0.05)),
        frame="tip",
        touch_links=["tip", "finger"],
        mass=0.7,
    )
    reduced = reduce_model(scene, "all", robot.positions())
    return World(reduced, ExactQuery(reduced))


def random_knots(at: World, rng: np.random.Generator) -> Floats:
    limits = at.reduced.limits
    lower, upper = np.maximum(limits.lower, -3.0), np.minimum(limits.upper, 3.0)
    return rng.uniform(lower, upper, (KNOTS, len(lower)))
