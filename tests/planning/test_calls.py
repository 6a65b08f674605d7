"""From `plan` it is not far to the mathematics: the flow can be followed without getting lost."""

import sys
from collections.abc import Callable

import pytest

import trajopt as to
from trajopt.optimise.solvers.sqp import NativeDescent

MOST_FRAMES = 9
"""Python frames from `plan` to the one that calls a native core, both counted, and that of the decorator
which names unknown arguments."""


def frames_of_plan(names: list[str]) -> Callable[[], None]:
    """Return what writes down the names of the functions on the stack, from `plan` inwards."""

    def note() -> None:
        frame, stack = sys._getframe(2), []
        while frame is not None and frame.f_code is not to.plan.__code__:
            stack.append(frame.f_code.co_name)
            frame = frame.f_back
        if frame is not None and "plan_once" in stack and not names:
            names.extend(["plan", *reversed(stack)])

    return note


@pytest.mark.parametrize(("kind", "name"), [(NativeDescent, "begin"), (NativeDescent, "descend")])
def test_few_calls_from_plan_to_the_native_calls_of_a_descent(
    kind: type, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    names: list[str] = []
    note, inner = frames_of_plan(names), getattr(kind, name)

    def counted(*arguments: object) -> object:
        note()
        return inner(*arguments)

    monkeypatch.setattr(kind, name, counted)
    assert to.plan(to.named_problem("cup_past_pillar")).verified
    # What was replaced stands for the frame of the same name: it is the one that calls the core.
    assert names and len(names) + 1 <= MOST_FRAMES, names
