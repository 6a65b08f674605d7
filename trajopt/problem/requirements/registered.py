"""Functions that modules register for a kind of requirement, in this library and in other packages."""

from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.metadata import entry_points
from pkgutil import iter_modules
from typing import Any, Protocol, TypeVar

from trajopt.problem.requirements.requirement import Requirement
from trajopt.values.errors import ProblemError, shown
from trajopt.values.errors.arguments import checked

GROUP = "trajopt.requirements"
"""Entry-point group in which packages name the modules that register their kinds of requirements."""

Result_co = TypeVar("Result_co", covariant=True)


class Dispatch(Protocol[Result_co]):
    """A function of `functools.singledispatch`."""

    @property
    def registry(self) -> Mapping[Any, Callable[..., Result_co]]:
        """The functions by class."""
        ...

    def dispatch(self, cls: Any) -> Callable[..., Result_co]:
        """Return the function for a class."""
        ...


@checked
def import_modules(package: str) -> None:
    """Import all modules of a package, without its subpackages, so that they register their functions."""
    for item in iter_modules(import_module(package).__path__):
        if not item.ispkg:
            import_module(f"{package}.{item.name}")


def import_installed() -> None:
    """Import the modules that installed packages name in the entry-point group."""
    for entry in entry_points(group=GROUP):
        entry.load()


def has(dispatch: Dispatch[object], kind: type[Requirement]) -> bool:
    """Say whether a function is registered for a kind of requirement."""
    return dispatch.dispatch(kind) is not dispatch.registry[object]


def registered(dispatch: Dispatch[Result_co], kind: type[Requirement], what: str) -> Callable[..., Result_co]:
    """Return the function that is registered for a kind of requirement.

    Installed packages are imported before it counts as missing.

    Args:
        dispatch: The function that dispatches.
        kind: The class of the requirement.
        what: What it registers, for the error.

    Raises:
        ProblemError: If there is none.
    """
    if not has(dispatch, kind):
        import_installed()
    if not has(dispatch, kind):
        raise ProblemError(
            f"no {what} is registered for {kind.__name__}: import the module that registers it, or name that "
            f"module in the entry-point group {shown(GROUP)}"
        )
    return dispatch.dispatch(kind)
