"""Methods of inverse kinematics by name: how configurations are moved until they hold requirements."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from trajopt.optimise.kinematics.projection import Projection
from trajopt.values.arrays import Floats
from trajopt.values.errors import SolverNotFound
from trajopt.values.errors.arguments import checked


class InverseMethod(Protocol):
    """A method of inverse kinematics."""

    @property
    def name(self) -> str:
        """Its name in `INVERSE_METHODS`."""
        ...

    def search(self, projection: Projection) -> Callable[[Floats], Floats] | None:
        """Return a function that moves starts, (S, n) -> (S, n), to candidate solutions of the requirements.

        The caller checks its results: it moves them into the limits, and the projection measures them.

        Args:
            projection: Has the robot and the requirements, `reduced` and `goals`.

        Returns:
            The search; None for the projection itself.

        Raises:
            RequirementNotSupported: If the method cannot state a requirement.
        """
        ...


@dataclass(frozen=True)
class LevenbergMarquardt:
    """Levenberg-Marquardt on a batch of starts (`Projection`); it takes every requirement."""

    name = "levenberg-marquardt"

    @checked
    def search(self, projection: Projection) -> None:
        """Leave the search to the projection; see `InverseMethod.search`."""
        del projection


def _placo() -> InverseMethod:
    from trajopt.optimise.kinematics.placo import Placo  # the package takes a while to import

    return Placo()


INVERSE_METHODS: Mapping[str, Callable[[], InverseMethod]] = {
    "levenberg-marquardt": LevenbergMarquardt,
    "placo": _placo,
}
"""Name of each method of inverse kinematics -> factory with default options."""


def inverse_method(method: str | InverseMethod) -> InverseMethod:
    """Return a method by name with its default options; a method object is returned unchanged.

    Raises:
        SolverNotFound: If the name is unknown.
    """
    if not isinstance(method, str):
        return method
    if method not in INVERSE_METHODS:
        raise SolverNotFound("inverse-kinematics method", method, INVERSE_METHODS)
    return INVERSE_METHODS[method]()
