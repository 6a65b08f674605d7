"""The report counts what is in the rows; its intervals hold what they say."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trajopt as to
from trajopt.lab.campaign import Campaign, CampaignFolder, Options, compare_campaigns, random_motions, summary
from trajopt.lab.campaign.columns import encoded
from trajopt.lab.campaign.page import lines, map_of, page
from trajopt.lab.campaign.summary import changed_by_chance, place_map, quantile, share
from trajopt.values.errors import CampaignError


def planned_as(
    campaign: Campaign, path: Path, verified: Mapping[int, bool], seconds: float = 0.01
) -> CampaignFolder:
    """Return a campaign whose first rows ended as stated."""
    folder = CampaignFolder.begin(campaign, path)
    rows: list[dict[str, Any]] = []
    for count, task in enumerate(folder.tasks()):
        good = verified[count]
        rows.append(
            {
                **{name: getattr(task, name) for name in ("id", "problem_id", "family", "number", "robot")},
                **{name: getattr(task, name) for name in ("seed", "options", "parameters")},
                **{"status": "SOLVED" if good else "STUCK", "verified": good, "clearance": 0.01},
                "cause": "SOLVED" if good else "STUCK: ball & link",
                **{"duration": 1.0 + count, "cpu_seconds": {"total": seconds * (1 + count)}},
            }
        )
    folder.write(encoded(rows))
    return folder


def test_wilson_interval_matches_published_values() -> None:
    found = share(8, 10)  # Brown, Cai and DasGupta, 2001: 0.490 to 0.943
    assert found.value == 0.8 and found.low == pytest.approx(0.490, abs=5e-4)
    assert found.high == pytest.approx(0.943, abs=5e-4)
    assert share(0, 5).low == 0.0 and share(5, 5).high == 1.0 and share(5, 5).low < 0.6


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    rng, runs = np.random.default_rng(0), 400
    of_shares = [share(int(rng.binomial(40, 0.85)), 40) for _ in range(runs)]
    of_p90 = [quantile(rng.exponential(size=60), 0.9) for _ in range(runs)]
    assert sum(each.low <= 0.85 <= each.high for each in of_shares) / runs > 0.92
    assert sum(each.low <= np.log(10.0) <= each.high for each in of_p90) / runs > 0.92


def test_a_quantile_of_one_value_is_that() -> None:
    found = quantile([3.0], 0.9)
    assert (found.low, found.value, found.high) == (3.0, 3.0, 3.0)


def test_changes_by_chance() -> None:
    assert changed_by_chance(0, 0) == 1.0 and changed_by_chance(3, 3) == 1.0
    assert changed_by_chance(10, 0) == pytest.approx(2 * 0.5**10)


def test_the_summary_counts_the_rows(scene: to.Scene, tmp_path: Path) -> None:
    sources = [random_motions(scene, 4, name="few"), random_motions(scene, 6, seed=1, name="more")]
    verified = {count: count != 7 for count in range(10)}
    found = summary(planned_as(Campaign("counted", sources), tmp_path, verified))
    assert (found.whole.rows, found.whole.verified, found.total) == (10, 9, 10)
    counts = [(each.name, each.rows, each.verified) for each in found.by_family]
    assert counts == [("few", 4, 4), ("more", 6, 5)]
    assert [each.name for each in found.by_robot] == ["planar2"]
    assert found.causes == {"STUCK: ball & link": 1}
    assert found.whole.cpu_median is not None and found.whole.cpu_median.value == pytest.approx(0.055)
    assert found.whole.clearance == 0.01 and found.places is None
    told, shown = "\n".join(lines(found)), page(found)
    assert "90.0 %" in told and "1 x STUCK: ball & link" in told
    assert "STUCK: ball &amp; link" in shown and "<svg" in shown
    assert "http" not in shown.replace("http://www.w3.org/2000/svg", "")  # it needs nothing beside itself


def test_a_real_campaign_has_a_report(planned: CampaignFolder) -> None:
    found = summary(planned)
    assert found.whole.success.value == 1.0 and len(found.times) == 12
    assert "12 of 12 rows" in lines(found)[0] and found.as_dict()["whole"]["rows"] == 12


def test_two_campaigns_are_compared_problem_by_problem(scene: to.Scene, tmp_path: Path) -> None:
    source = random_motions(scene, 12)
    first = planned_as(Campaign("old", [source]), tmp_path / "a", dict.fromkeys(range(12), True) | {0: False})
    other = Campaign("new", [random_motions(scene, 10)], [Options(attempts=3)])
    ended = dict.fromkeys(range(10), True) | {3: False, 4: False}
    second = planned_as(other, tmp_path / "b", ended, seconds=0.005)
    found = compare_campaigns(first, second)
    assert (found.common, found.only_first, found.only_second, found.verified) == (10, 2, 0, (9, 8))
    assert len(found.gained) == 1 and [each.after for each in found.lost] == ["STUCK", "STUCK"]
    assert found.chance == 1.0 and found.faster == (10, 0) and found.speed_chance < 0.01
    assert found.cpu_ratio is not None and found.cpu_ratio.value == pytest.approx(0.5)
    told = "\n".join(lines(summary(second), found))
    assert "1 gained, 2 lost (p = 1, McNemar's exact test)" in told and "STUCK" in page(
        summary(second), found
    )
    another = planned_as(Campaign("x", [random_motions(scene, 1, seed=9)]), tmp_path / "c", {0: True})
    with pytest.raises(CampaignError, match="no problem in common"):
        compare_campaigns(first, another)


def test_the_map_of_places_finds_the_best() -> None:
    rows = [
        {
            "verified": x == 0.1 and (y < 0.0 or yaw == 1.0),
            "parameters": {"x": x, "y": y, "z": 0.0, "yaw": yaw},
        }
        for x in (0.0, 0.1, 0.2)
        for y in (-0.5, 0.5)
        for yaw in (0.0, 1.0)
    ]
    found = place_map(rows)
    assert found is not None and found.best == (0.1, -0.5, 0.0, 1.0)
    assert found.verified.tolist() == [[0.0, 2.0, 0.0], [0.0, 1.0, 0.0]] and (found.rows == 2).all()
    drawn = map_of(found)
    assert (
        drawn.count("<rect") == 6
        and "<circle" in drawn
        and "dark: all" in drawn
        and "x 0.1 m, y 0.5 m: 50%" in drawn
    )


def test_a_campaign_without_rows_has_no_report(scene: to.Scene, tmp_path: Path) -> None:
    begun = CampaignFolder.begin(Campaign("none", [random_motions(scene, 1)]), tmp_path)
    with pytest.raises(CampaignError, match="no row yet"):
        summary(begun)
