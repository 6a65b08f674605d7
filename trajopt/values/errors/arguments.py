"""Argument checks against annotations; errors name the argument."""

import inspect
import types
import typing
from collections.abc import Callable, Iterable, Mapping
from dataclasses import InitVar, fields, is_dataclass
from functools import cache, wraps
from math import isnan
from pathlib import Path
from typing import Any, TypeVar, Union, cast

import numpy as np
from numpy.typing import NDArray

from trajopt.values.arrays import Floats, is_array_like, numbers
from trajopt.values.errors import ProblemError, ShapeError, UnknownArgument, kind_words, listed, shown

Target = TypeVar("Target", bound=Callable[..., Any])
Kind = TypeVar("Kind", bound=type)
Test = Callable[[Any], bool]

NUMBERS: Mapping[object, tuple[type[object], ...]] = {
    float: (int, float, np.integer, np.floating),
    int: (int, np.integer),
}
"""Types that count as numbers; truth values and text do not."""
WORDS: Mapping[object, str] = {
    str: "a name", float: "a number", int: "a whole number", bool: "true or false", type(None): "None",
}  # fmt: skip
SEVERAL = (list, tuple, set, frozenset)
"""Collections whose members are checked; others may be readable only once."""


def checked(target: Target) -> Target:
    """Make a function, or the constructor of a class, refuse arguments that do not match their annotations.

    Lists and tensors given for an array become arrays. Shapes and ranges are not checked here.

    Raises:
        ProblemError: By the function, if an argument is of another kind.
        ShapeError: By the function, if a number is required and the argument is not a number.
        UnknownArgument: By the function, if it has no argument of that name.
    """
    if inspect.isclass(target):
        cast("Any", target).__init__ = checked(target.__init__)
        return cast("Target", target)
    kinds, code = Kinds(target), inspect.unwrap(target).__code__
    names = code.co_varnames[: code.co_argcount]
    known = _names_of(target)

    @wraps(target)
    def call(*args: Any, **kwargs: Any) -> Any:
        if kwargs and known is not None and not kwargs.keys() <= known:
            raise _unknown(target, kwargs, known)
        for place, (name, value) in enumerate(zip(names, args, strict=False)):
            test, hint = kinds[name]
            if not test(value):
                args = (*args[:place], _array(name, hint, value), *args[place + 1 :])
        for name, value in kwargs.items():
            test, hint = kinds[name]
            if not test(value):
                kwargs[name] = _array(name, hint, value)
        return target(*args, **kwargs)

    return cast("Target", call)


def checked_class(cls: Kind) -> Kind:
    """Make the constructor and the public methods of a class refuse arguments like `checked`."""
    for name, member in vars(cls).copy().items():
        if name[0] == "_" and name != "__init__":
            continue
        if isinstance(member, staticmethod):
            setattr(cls, name, staticmethod(checked(cast("staticmethod[..., Any]", member).__func__)))
        elif inspect.isfunction(member) and _names_of(member) != frozenset(("self",)):
            setattr(cls, name, checked(member))
    return cls


def named(target: Target) -> Target:
    """Make a function that checks its own arguments suggest the likely one for an unknown name."""
    known = _names_of(target)

    @wraps(target)
    def call(*args: Any, **kwargs: Any) -> Any:
        if known is not None and not kwargs.keys() <= known:
            raise _unknown(target, kwargs, known)
        return target(*args, **kwargs)

    return cast("Target", call)


def _names_of(target: Callable[..., Any]) -> frozenset[str] | None:
    code = inspect.unwrap(target).__code__
    if code.co_flags & inspect.CO_VARKEYWORDS:
        return None
    return frozenset(code.co_varnames[code.co_posonlyargcount : code.co_argcount + code.co_kwonlyargcount])


def _unknown(target: Callable[..., Any], given: Mapping[str, Any], known: frozenset[str]) -> UnknownArgument:
    ordered = [
        name for name in inspect.unwrap(target).__code__.co_varnames if name in known - {"self", "cls"}
    ]
    name = next(each for each in given if each not in known)
    called = target.__qualname__.removesuffix(".__init__")
    return UnknownArgument(called, name, ordered, _option(Kinds(target), ordered, name))


def _option(kinds: "Kinds", arguments: Iterable[str], name: str) -> str:
    for argument in arguments:
        for kind in _parts(kinds[argument][1]):
            if is_dataclass(kind) and name in {each.name for each in fields(kind)}:
                return f"{argument}={cast('type', kind).__name__}({name}=...)"
    return ""


def check_arguments(function: Callable[..., Any], given: Mapping[str, Any]) -> None:
    """Refuse arguments that do not match their annotations, like `checked`, from within a function."""
    kinds = _kinds_once(function)
    for name, value in given.items():
        test, hint = kinds[name]
        if not test(value):
            _array(name, hint, value)


def _anything(value: object) -> bool:
    del value
    return True


class Kinds(dict[str, tuple[Test, Any]]):
    """The type test and annotation of each parameter of a function, created on first use."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__()
        made: Any = function.__init__ if inspect.isclass(function) else function
        self._annotations, self._seen = made.__annotations__, getattr(inspect.unwrap(made), "__globals__", {})

    def __missing__(self, name: str) -> tuple[Test, Any]:
        hint = self._annotations.get(name, Any)
        if isinstance(hint, str):
            try:
                only = types.SimpleNamespace(__annotations__={name: hint})
                hint = typing.get_type_hints(only, globalns=self._seen)[name]
            except NameError:  # only type checkers import what it names
                pass
        self[name] = _test(hint), hint
        return self[name]


def _parts(hint: Any) -> tuple[Any, ...]:
    if isinstance(hint, InitVar):
        return _parts(cast(Any, hint).type)
    if typing.get_origin(hint) in (Union, types.UnionType):
        return tuple(part for each in typing.get_args(hint) for part in _parts(each))
    return (hint,)


def _open(hint: Any) -> bool:
    """Return whether any value is accepted, or only numpy can decide."""
    if hint is Any or hint is object or isinstance(hint, TypeVar | typing.ForwardRef | str):
        return True
    kind = typing.get_origin(hint) or hint
    return getattr(kind, "__module__", "").startswith("numpy._typing")


@cache
def _kinds_once(function: Callable[..., Any]) -> Kinds:
    return Kinds(function)


def _within(kind: Any, base: type[object]) -> bool:
    return inspect.isclass(kind) and issubclass(kind, base)


@cache
def _test(hint: Any) -> Test:
    parts = _parts(hint)
    if any(map(_open, parts)):
        return _anything
    tests = tuple(_test_of_one(part) for part in parts)
    if len(tests) == 2:  # mostly something or None
        first, second = tests
        return lambda value: first(value) or second(value)
    return tests[0] if len(tests) == 1 else lambda value: any(test(value) for test in tests)


def _test_of_one(hint: Any) -> Test:
    kind: Any = typing.get_origin(hint) or hint
    inner = typing.get_args(hint)
    if kind in NUMBERS:
        numbers = NUMBERS[kind]
        return lambda value: isinstance(value, numbers) and _is_number(value)
    if kind is type(None):
        return lambda value: value is None
    if kind is np.ndarray:
        return lambda value: isinstance(value, np.ndarray)
    if kind in (Callable, typing.get_origin(Callable[..., Any])):
        return callable
    if inner and _within(kind, Mapping):
        return lambda value: isinstance(value, Mapping)
    if inner and _within(kind, Iterable):
        return _test_of_several(kind, inner)
    if getattr(kind, "_is_protocol", False):
        members = _members(kind)
        return lambda value: all(hasattr(value, name) for name in members)
    return lambda value: isinstance(value, kind)


def _is_number(value: object) -> bool:
    try:
        return not isinstance(value, bool) and not isnan(cast("float", value))
    except OverflowError:
        return False


def _test_of_several(kind: type[object], inner: tuple[Any, ...]) -> Test:
    of_kind: tuple[type[object], ...] = (list, tuple) if kind in (list, tuple) else (kind, np.ndarray)
    record = kind is tuple and Ellipsis not in inner
    tests = tuple(map(_test, inner)) if record else (_test(inner[0]),)

    def test(value: Any) -> bool:
        if isinstance(value, str | bytes) or not isinstance(value, of_kind):
            return False
        if not isinstance(value, SEVERAL):
            return True
        members = tuple(cast("Iterable[Any]", value))
        if record:
            return len(members) == len(tests) and all(
                each(item) for each, item in zip(tests, members, strict=True)
            )
        return all(map(tests[0], members))

    return test


@cache
def _members(protocol: type[object]) -> frozenset[str]:
    own = (kind for kind in protocol.__mro__ if getattr(kind, "_is_protocol", False))
    names = {name for kind in own for name in (*vars(kind), *vars(kind).get("__annotations__", ()))}
    return frozenset(name for name in names if not name.startswith("_") or name == "__call__")


def _array(name: str, hint: Any, value: Any) -> NDArray[Any]:
    """Return the array that a value of another kind than the annotation's stands for."""
    parts = _parts(hint)
    arrays = any(typing.get_origin(part) is np.ndarray for part in parts)
    if not arrays or not is_array_like(value):
        raise _refusal(name, hint, value)
    return numbers(name, value) if Floats in parts else np.asarray(value)


def _refusal(name: str, hint: Any, value: Any) -> ProblemError | ShapeError:
    parts = _parts(hint)
    holds = [part for part in parts if _is_collection(part)]
    if len(holds) == 1 and isinstance(value, SEVERAL):
        inner = typing.get_args(holds[0])[0]
        test = _test(inner)
        for member in cast("Iterable[Any]", value):
            if not test(member):
                words = f"each of {name} must be {_words(_parts(inner))}, is {shown(member)}"
                return ProblemError(f"{words}{_given_elsewhere(member)}")
    if set(parts) <= {float, type(None)}:
        return ShapeError(name, f"must be a number, is {shown(cast('object', value))}")
    return ProblemError(
        f"{name} must be {_words(parts)}, is {shown(cast('object', value))}{_lacking(parts, value)}"
    )


def _given_elsewhere(value: object) -> str:
    argument = getattr(type(value), "GIVEN_AS", "")
    return f"; it is given as {argument}" if argument else ""


def _lacking(parts: tuple[Any, ...], value: Any) -> str:
    kinds = [typing.get_origin(part) or part for part in parts]
    protocols = [kind for kind in kinds if getattr(kind, "_is_protocol", False)]
    if len(protocols) != 1:
        return ""
    missing = sorted(name for name in _members(protocols[0]) if not hasattr(value, name))
    return f"; it lacks {listed(missing)}"


def _is_collection(hint: Any) -> bool:
    kind, inner = typing.get_origin(hint), typing.get_args(hint)
    several = _within(kind, Iterable) and not _within(kind, Mapping) and kind is not np.ndarray
    return several and (kind is not tuple or Ellipsis in inner)


def _words(parts: tuple[Any, ...]) -> str:
    kinds = [part for part in parts if part is not type(None)] or [type(None)]
    if kinds[0] is Path:  # a text is a path too
        kinds = [part for part in kinds if part is not str]
    words: dict[str, None] = {}
    for part in kinds:
        again = _is_collection(part) and all(each in kinds for each in _parts(typing.get_args(part)[0]))
        words["several" if again else _words_of_one(part)] = None
    *others, last = words
    return f"{', '.join(others)} or {last}" if others else last


def _words_of_one(hint: Any) -> str:
    kind: Any = typing.get_origin(hint) or hint
    if kind in WORDS:
        return WORDS[kind]
    if kind is np.ndarray:
        return "an array"
    if kind in (Callable, typing.get_origin(Callable[..., Any])):
        return "a function"
    if _within(kind, Mapping):
        return "a mapping"
    if _is_collection(hint):
        return "a list of names" if typing.get_args(hint)[0] is str else "a list or another collection"
    if kind is Path:
        return "the path of a file"
    return kind_words(kind)
