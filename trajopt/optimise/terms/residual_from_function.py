"""A residual from a plain Python function of a configuration."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trajopt.problem.motion import Motion
from trajopt.values.arrays import Floats, Rows, floats
from trajopt.values.errors import ShapeError, shown
from trajopt.values.errors.arguments import checked

DIFFERENCES = "finite differences"
"""Added to the name of a residual whose derivative is not given."""
STEP = 1e-6
"""Step of the differences in every joint to either side [rad | m]."""

Function = Callable[[Floats], ArrayLike]
"""The group's positions, shape (n,) [rad | m] -> a number, or a vector of always the same length."""


@dataclass(frozen=True, eq=False)
class FunctionResidual:
    """A function of one configuration, evaluated at every sample; its components are the function's.

    Attributes:
        title: Your name for it.
        function: The function; it must return the same value for the same positions.
        jacobian: Positions (n,) -> derivatives, shape (components, n), or (n,) of a single number;
            central differences are taken when None.
        step: Step of the differences [rad | m].
    """

    title: str
    function: Function
    jacobian: Function | None
    step: float

    @property
    def name(self) -> str:
        """Its title, with a note if the derivative is by differences."""
        return self.title if self.jacobian is not None else f"{self.title} ({DIFFERENCES})"

    def linearise(self, motion: Motion) -> Rows:
        """Evaluate and differentiate at all samples.

        Raises:
            ShapeError: If the function or its Jacobian returns another shape, or is not finite.
        """
        joints = motion.positions.shape[1]
        values = [self._at(position) for position in motion.positions]
        count = len(values[0]) if values else 0
        slopes = [self._slope(position, count) for position in motion.positions]
        return motion.rows_of_all(
            np.array(values).reshape(len(values), count), np.array(slopes).reshape(len(values), count, joints)
        )

    def _at(self, position: Floats) -> Floats:
        value = np.atleast_1d(np.asarray(self.function(position), dtype=np.float64))
        return floats(f"value of {shown(self.title)}", value, (None,))

    def _slope(self, position: Floats, count: int) -> Floats:
        joints = len(position)
        if self.jacobian is not None:
            given = np.atleast_2d(np.asarray(self.jacobian(position), dtype=np.float64))
            return floats(f"Jacobian of {shown(self.title)}", given, (count, joints))
        slope = np.empty((count, joints))
        for joint, away in enumerate(self.step * np.eye(joints)):
            high, low = self._at(position + away), self._at(position - away)
            if not len(high) == len(low) == count:
                raise ShapeError(f"value of {shown(self.title)}", "must have the same length everywhere")
            slope[:, joint] = (high - low) / (2.0 * self.step)
        return slope


@checked
def residual_from_function(
    name: str, function: Function, *, jacobian: Function | None = None, step: float = STEP
) -> FunctionResidual:
    """Make a residual of a function of the positions; `constraint` bounds it, `Cost` penalises it.

    The judge calls the same function at samples of the timed motion, and its certificate states so.

    Args:
        name: Shown in reports; without a Jacobian "(finite differences)" is added.
        function: Of the group's positions, shape (n,) [rad | m]: a number or a vector.
        jacobian: Its derivatives, shape (components, n); central differences when None.
        step: Step of the differences, > 0 [rad | m].

    Raises:
        ShapeError: If the step is not positive.
    """
    if not step > 0.0:
        raise ShapeError("step", f"must be positive, is {step}")
    return FunctionResidual(name, function, jacobian, step)
