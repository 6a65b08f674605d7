"""A user's residual as a CasADi expression; its derivative is automatic."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

from trajopt.problem.motion import Motion
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Rows
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked

if TYPE_CHECKING:
    import casadi as ca

    from trajopt.optimise.terms.symbolic import SymbolicKinematics

Build = Callable[["SymbolicKinematics"], "ca.SX"]
"""Makes the expression, a scalar or a column, of the symbols in `SymbolicKinematics.q`."""


@checked
@dataclass(frozen=True, eq=False)
class Expression:
    """A function of the configuration, evaluated at every sample.

    Attributes:
        name: Shown in reports.
        build: Makes the expression; called once for each robot in its scene.
    """

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
            compiled[self] = self._compiled(reduced)
        value, jacobian = compiled[self](motion.positions)
        return motion.rows_of_all(value, jacobian)

    def expression(self, kinematics: "SymbolicKinematics") -> "ca.SX":
        """Return the expression; see `Symbolic`."""
        import casadi as ca

        # What is fixed to the world may make it a plain number.
        return ca.SX(self.build(kinematics))

    def _compiled(self, reduced: ReducedModel) -> "_Compiled":
        from trajopt.optimise.terms.symbolic import SymbolicKinematics

        kinematics = SymbolicKinematics(reduced)
        return _Compiled(self.name, kinematics.q, self.expression(kinematics))


def _by_expression(reduced: ReducedModel) -> WeakKeyDictionary[Expression, "_Compiled"]:
    del reduced
    return WeakKeyDictionary()


class _Compiled:
    """An expression and its Jacobian as a CasADi function, mapped over any number of samples."""

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
        """Evaluate at configurations (S, n): values (S, d) and derivatives (S, d, n)."""
        count, joints = positions.shape
        if count == 0:
            return positions[:, :0].reshape(0, self._rows), positions.reshape(0, self._rows, joints)
        if count not in self._mapped:
            self._mapped[count] = self._function.map(count)
        value, slope = self._mapped[count](positions.T)
        return value.full().T, slope.full().T.reshape(count, self._rows, joints)
