"""Contacts at single times become intervals."""

import pytest

from trajopt.scene.clearances import ContactAllowance
from trajopt.simulation.rollout import ContactLog

PAIR = ("cup", "table")


def test_contacts_merge_until_a_gap() -> None:
    log = ContactLog((), 1.0)
    for time, depth in ((0.1, 1e-3), (0.102, 3e-3), (0.115, 2e-3), (0.3, 1e-4)):
        log.record(time, {PAIR: depth})
        log.record(time + 0.001, {})
    first, second = log.contacts()
    assert (first.start, first.end, first.depth) == (0.1, 0.115, 3e-3)
    assert (second.start, second.end, second.depth) == (0.3, 0.3, 1e-4)
    assert str(first) == "cup touches table from 0.100 s to 0.115 s, 3.00 mm deep"


def test_pairs_are_kept_apart() -> None:
    log = ContactLog((), 1.0)
    log.record(0.2, {PAIR: 1e-3, ("arm", "wall"): 2e-3})
    assert [contact.pair for contact in log.contacts()] == [("arm", "wall"), PAIR]


@pytest.mark.parametrize(
    ("start", "end", "depth", "meant"),
    [
        (0.0, 0.1, 1e-3, True),
        (0.0, 0.3, 1e-3, False),
        (0.0, 0.1, 5e-3, False),
        (0.95, 1.2, 1e-3, True),
        (0.5, 1.0, 1e-3, False),
    ],
)
def test_allowance_must_cover_the_whole_contact(start: float, end: float, depth: float, meant: bool) -> None:
    allowance = ContactAllowance("lift-off", "table", "cup", 2e-3, 0.2, 0.1)
    log = ContactLog((allowance,), 1.0)
    time = start
    while time <= end + 1e-9:
        log.record(time, {PAIR: depth})
        time += 0.01
    (contact,) = log.contacts()
    assert (contact.allowance == "lift-off") is meant
    assert ("allowed" in str(contact)) is meant
