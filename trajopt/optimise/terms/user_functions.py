"""A user's residual as a CasADi expression; its derivative is automatic."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from trajopt.problem.motion import Motion
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Rows, floats
from trajopt.values.errors import ProblemError, ShapeError, shown
from trajopt.values.errors.arguments import checked

if TYPE_CHECKING:
    import casadi as ca

    from trajopt.optimise.terms.symbolic import SymbolicKinematics

Build = Callable[["SymbolicKinematics"], "ca.SX"]
"""Makes the expression, a scalar or a column, of the symbols in `SymbolicKinematics.q`."""


@checked
@dataclass(frozen=True, eq=False)
class Expression:
    """A function of the configuration at every sample, built once for each robot in its scene."""

    name: str
    build: Build

    def linearise(self, motion: Motion) -> Rows:
        """Evaluate and differentiate at all samples.

        Raises:
            ProblemError: If the expression is not a column, or has symbols other than the positions.
        """
        reduced = motion.query.reduced
        compiled = reduced.derived(_by_expression)
        if self not in compiled:
            from trajopt.optimise.terms.symbolic import SymbolicKinematics

            kinematics = SymbolicKinematics(reduced)
            compiled[self] = _Compiled(self.name, kinematics.q, self.expression(kinematics))
        value, jacobian = compiled[self](motion.positions)
        return motion.rows_of_all(value, jacobian)

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        import casadi as ca

        # What is fixed to the world may make it a plain number.
        return ca.SX(self.build(kinematics))


def _by_expression(reduced: ReducedModel) -> WeakKeyDictionary[Expression, "_Compiled"]:
    del reduced
    return WeakKeyDictionary()


class _Compiled:
    """An expression and its Jacobian as a CasADi function over samples."""

    def __init__(self, name: str, q: "ca.SX", value: "ca.SX") -> None:
        import casadi as ca

        if value.shape[1] != 1:
            raise ProblemError(
                f"expression {shown(name)}: needs a scalar or a column, has shape {value.shape}"
            )
        strange = {str(symbol) for symbol in ca.symvar(value)} - {str(symbol) for symbol in ca.symvar(q)}
        if strange:
            raise ProblemError(
                f"expression {shown(name)}: has symbols of its own, {', '.join(sorted(strange))}"
            )
        self._rows = value.shape[0]
        self._function = ca.Function("expression", [q], [value, ca.vec(ca.jacobian(value, q).T)])
        self._mapped: dict[int, ca.Function] = {}

    def __call__(self, positions: Floats) -> tuple[Floats, Floats]:
        count, joints = positions.shape
        if count == 0:
            return positions[:, :0].reshape(0, self._rows), positions.reshape(0, self._rows, joints)
        if count not in self._mapped:
            self._mapped[count] = self._function.map(count)
        value, slope = self._mapped[count](positions.T)
        return value.full().T, slope.full().T.reshape(count, self._rows, joints)


DIFFERENCES = "finite differences"
"""Added to the name of a residual whose derivative is not given."""
STEP = 1e-6
"""Step of the differences in every joint to either side [rad | m]."""

Function = Callable[[Floats], ArrayLike]
"""The group's positions, shape (n,) [rad | m] -> a number, or a vector of always the same length."""


@dataclass(frozen=True, eq=False)
class FunctionResidual:
    """A function of one configuration, evaluated at every sample.

    Attributes:
        function: The function; it must return the same value for the same positions.
        jacobian: Positions (n,) -> derivatives, shape (components, n), or (n,) of a single number;
            central differences are taken when None.
    """

    title: str
    function: Function
    jacobian: Function | None
    step: float

    @property
    def name(self) -> str:
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
