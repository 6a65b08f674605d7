"""A cluster of Ray on this machine gives the same rows; benchmarks/campaign breaks it in many ways."""

import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from benchmarks.campaign.cluster import Cluster, cluster, workers
from tests.lab.campaign.rooms import rows_of
from trajopt.lab.campaign import Campaign, CampaignFolder, Ray, run_campaign
from trajopt.values.errors import MissingExtra, ProblemError


@pytest.fixture(scope="module")
def nodes(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    with cluster(tmp_path_factory.mktemp("ray")) as running:
        yield running


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.skipif(find_spec("ray") is None, reason="needs the extra `ray`")
@pytest.mark.skipif(sys.platform != "linux", reason="processes are listed in /proc")
def test_a_cluster_gives_the_rows_of_this_machine(
    nodes: Cluster, small: Campaign, planned: CampaignFolder, tmp_path: Path
) -> None:
    assert rows_of(run_campaign(small, tmp_path / "ray", Ray(nodes.address))) == rows_of(planned)
    assert workers(set(nodes.mine())) == []


def test_without_ray_the_extra_is_named(
    small: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def without(name: str) -> None:
        del name

    monkeypatch.setattr("trajopt.lab.campaign.cluster.find_spec", without)
    with pytest.raises(MissingExtra, match=r"trajopt-planner\[ray\]"):
        run_campaign(small, tmp_path / "none", Ray())


def test_a_negative_number_of_actors_is_refused() -> None:
    with pytest.raises(ProblemError, match="workers must not be negative"):
        Ray(workers=-1)
