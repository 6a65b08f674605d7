"""The work that planning takes does not grow unseen: exact counts against the committed baseline."""

import json

import pytest

import trajopt as to
from benchmarks.gate import BASELINE, ROOM, counts, total


def test_counts_do_not_grow() -> None:
    try:
        found = counts()
    except to.MissingExtra as missing:
        pytest.skip(str(missing))
    baseline = json.loads(BASELINE.read_text())
    assert found.keys() == baseline.keys()
    assert total(found)["solved"] == len(found)
    for name, limit in total(baseline).items():
        assert total(found)[name] <= ROOM * limit, (
            f"{name} grew: mend it, or write the baseline anew and say why"
        )
