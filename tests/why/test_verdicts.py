"""Verdicts on problems without a solution, drawn at random: right, and never a plan."""

import pytest

import trajopt as to
from tests.why.unsolvable import FAMILIES, Unsolvable, draw
from trajopt.why import Certainty

FEW, MANY = 9, 200
RIGHT = 0.95
"""Share of right verdicts that is demanded."""


def right(item: Unsolvable) -> bool:
    """Plan, explain, and say whether both tell the truth; calling it solved is never forgiven."""
    result = to.plan(item.problem)
    assert result.status is not to.Status.SOLVED
    told = result.explain()
    assert str(told).startswith(result.reason)
    known = told.certainty is Certainty.PROVEN
    return told.status in item.right and known == item.proven


@pytest.mark.parametrize("item", list(draw(FEW)), ids=lambda item: f"{item[0]}-{item[1]}")
def test_a_few(item: tuple[str, int, Unsolvable]) -> None:
    assert right(item[2])


@pytest.mark.slow
@pytest.mark.timeout(3000)
def test_many() -> None:
    wrong: list[str] = []
    count = dict.fromkeys((make.__name__ for makers in FAMILIES.values() for make in makers), 0)
    for name, number, item in draw(MANY):
        count[name] += 1
        if not right(item):
            wrong.append(f"{name} {number}")
    assert min(count.values()) >= 15
    assert len(wrong) <= (1.0 - RIGHT) * MANY, wrong
