"""Random valid configurations: within limits, clear of everything, and holding the requirements."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from trajopt.geometry import Evaluator, evaluator
from trajopt.optimise.kinematics.projection import Projection
from trajopt.optimise.kinematics.validity import clear, count_of, pair_margins, requirements_of
from trajopt.problem.requirements import Requirement
from trajopt.robot.joints import draw_positions
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Value, readonly
from trajopt.values.errors.arguments import checked

BATCH = 4096
"""Configurations drawn in a batch."""
MOST_DRAWS = 200
"""Most draws for each configuration wanted; at least a few batches."""

Progress = Callable[[int], None]
"""Called with the number found so far."""


@dataclass(frozen=True, eq=False)
class RandomConfigurations(Value):
    """Valid configurations, and counts of the rejected draws.

    Attributes:
        positions: Shape (k, n) [rad | m]; k is smaller than `count` if too few were found.
        missed: Number of draws that could not be projected onto the requirements.
        colliding: Number of others that came nearer to something than the margin.
    """

    positions: Floats
    drawn: int
    missed: int
    colliding: int

    def __str__(self) -> str:
        return (
            f"{len(self.positions)} valid configurations of {self.drawn} drawn; {self.colliding} collided, "
            f"{self.missed} did not hold what is required"
        )


@checked
def random_configurations(
    reduced: ReducedModel,
    count: int,
    *,
    rng: np.random.Generator,
    margin: float | None = None,
    requirements: Sequence[Requirement] = (),
    progress: Progress | None = None,
) -> RandomConfigurations:
    """Draw configurations evenly within limits and keep the valid ones.

    With requirements each draw is projected onto them, so their density is not uniform
    (`docs/decisions/goal-configurations.md`).

    Args:
        margin: Clearance to keep from everything [m]; the scene's own margins when None.

    Raises:
        ShapeError: If the count is not positive or the margin is negative.
        NameNotFound: If a requirement names an unknown frame or joint.
    """
    wanted = requirements_of(reduced, "requirements", requirements)
    count_of("count", count)
    sampler = Sampler(evaluator(reduced), wanted, pair_margins(reduced, margin), rng)
    found: list[Floats] = []
    kept = drawn = missed = colliding = 0
    most = max(MOST_DRAWS * count, 4 * BATCH)
    while kept < count and drawn < most:
        # A few more than are missing: about as many as were lost so far will be lost again.
        share = (kept + 1) / (drawn + 1) if drawn else 1.0
        size = int(min(BATCH, max((count - kept) / share, 16), most - drawn))
        batch = sampler.draw(size)
        found.append(batch.positions)
        kept += len(batch.positions)
        drawn, missed, colliding = drawn + size, missed + batch.missed, colliding + batch.colliding
        if progress is not None:
            progress(min(kept, count))
    positions = readonly(np.concatenate(found)[:count])
    return RandomConfigurations(positions, drawn, missed, colliding)


class Sampler:
    """Draws batches of configurations and keeps the valid ones."""

    def __init__(
        self, query: Evaluator, requirements: Sequence[Requirement], margin: Floats, rng: np.random.Generator
    ) -> None:
        """Create a sampler; `margin` is the clearance of each pair, shape (p,) [m]."""
        self._query, self._margin, self._rng = query, margin, rng
        self._projection = Projection(query.reduced, requirements, query) if requirements else None

    def draw(self, count: int) -> RandomConfigurations:
        """Draw a number of configurations and return the valid ones, in the order drawn."""
        positions = draw_positions(self._query.reduced.limits, count, rng=self._rng)
        if self._projection is not None:
            ended = self._projection(positions)
            positions = ended.positions[ended.violation == 0.0]
        free = clear(self._query, positions, self._margin)
        missed = count - len(positions)
        return RandomConfigurations(positions[free], count, missed, int((~free).sum()))
