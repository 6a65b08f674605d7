"""The benchmark of four robots: whose turn it is, what a hang counts as, and what its tables say."""

from pathlib import Path

import pytest

from benchmarks.motion_bench_maker import in_turn, listed, row_name
from benchmarks.sections import Done, comparison, outcome_of, section
from tests.lab.suite.suite.outcomes import GOOD
from trajopt.lab.suite.instance import by_set, summary
from trajopt.planning.status import Status

SECONDS = 60.0


def files(folder: Path, **sets: int) -> Path:
    for name, count in sets.items():
        (folder / name).mkdir(parents=True)
        for number in range(1, count + 1):
            (folder / name / f"scene{number:04}.yaml").touch()
    return folder


def done(name: str, *rows: dict[str, object], unaskable: tuple[str, ...] = ()) -> Done:
    outcomes = [outcome_of(row, SECONDS) for row in rows]
    reasons = {item.problem: ["start: a touches b"] * (item.problem in unaskable) for item in outcomes}
    return Done(name, outcomes, reasons, sum(row["outcome"] == "hang" for row in rows))


def solved(problem: str, cpu_seconds: float, attempts: int = 1) -> dict[str, object]:
    told = GOOD.as_dict() | {"problem": problem, "cpu_seconds": cpu_seconds, "attempts": attempts}
    return {"outcome": "verified", "told": told}


HANG: dict[str, object] = {
    "outcome": "hang", "family": "fetch/cage", "seed": 7, "detail": "ended after 60 s"
}  # fmt: skip


def test_every_robot_is_spread_over_the_run(tmp_path: Path) -> None:
    long = listed(files(tmp_path / "fetch", box=4, cage=4), None)
    assert long[:3] == [("fetch/box", 1), ("fetch/cage", 1), ("fetch/box", 2)]
    short = listed(files(tmp_path / "baxter", easy=9), 2)
    assert short == [("baxter/easy", 1), ("baxter/easy", 2)]
    turns = [family for family, _ in in_turn({"fetch": long, "baxter": short})]
    assert [place for place, family in enumerate(turns) if family == "baxter/easy"] == [2, 7]
    assert row_name(*long[0]) == "fetch/box-1"
    with pytest.raises(SystemExit, match="no <set>"):
        listed(tmp_path, None)


def test_a_hang_counts_with_all_its_time() -> None:
    outcome = outcome_of(HANG, SECONDS)
    assert outcome.problem == "cage/7" and outcome.set_name == "cage" and not outcome.verified
    assert outcome.status is Status.OUT_OF_TIME and outcome.cpu_seconds == SECONDS


def test_robots_side_by_side() -> None:
    panda = done("panda", solved("box/1", 0.02), solved("box/2", 0.04), solved("box/3", 0.04))
    fetch = done(
        "fetch",
        HANG,
        solved("box/1", 0.2, 3),
        solved("box/2", 0.2, 3),
        solved("box/9", 9.0),
        unaskable=("box/9",),
    )
    _, _, one, other = comparison([panda, fetch]).splitlines()
    assert one.startswith("| Panda | 3 | 3 | 3 | 100.0 % | 0 | 1 / 1 | 40 / 40 | 1.0 / 1.0 |")
    assert other.startswith("| Fetch | 4 | 3 | 2 | 66.7 % | 1 | 3 / 3 | 200 / ")
    assert " 5.0 / " in other
    assert " |  |" in comparison([fetch]).splitlines()[2], "without the Panda there is no ratio"


def test_a_section_lists_unverified_problems() -> None:
    fetch = done("fetch", HANG, solved("box/1", 0.2), solved("box/9", 9.0), unaskable=("box/9",))
    text = section(fetch, summary(fetch.outcomes, fetch.askable), by_set(fetch.outcomes, fetch.askable))
    assert "| box | 2 | 1 | 1 | 100.0 % |" in text and "| all | 3 | 1 | 1 | 50.0 % |" in text
    assert "- cage/7: OUT_OF_TIME: hang: ended after 60 s" in text
