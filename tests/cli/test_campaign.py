"""`trajopt campaign`: its commands say what they did, and leave what they say."""

import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.cli.process import trajopt
from tests.lab.campaign.rooms import REQUEST, SCENE
from trajopt.server.warehouse import Warehouse

pytestmark = pytest.mark.timeout(280)


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    scene, request = tmp_path / "scene.yaml", tmp_path / "request.yaml"
    scene.write_text(SCENE)
    request.write_text(REQUEST)
    return scene, request


def test_a_grid_of_places_from_the_run_to_the_map(files: tuple[Path, Path], tmp_path: Path) -> None:
    scene, request = files
    out = tmp_path / "places"
    words = ("placements", "--robot", "planar2", "--scene", scene, "--request", request, "--workers", 1)
    done = trajopt("campaign", "run", *words, "--x", 0, 1, 2, "--y", 0, 0.5, 2, "--out", out, "--json")
    assert done.returncode == 0
    assert json.loads(done.stdout)["done"] == 4
    told = trajopt("campaign", "status", out)
    assert told.returncode == 0 and "4 of 4 rows" in told.stdout
    page, picture = tmp_path / "report.html", tmp_path / "map.svg"
    told = trajopt("campaign", "report", out, "--html", page, "--map", picture, "--beside", out)
    assert "the base does best at" in told.stdout and "4 problems in common" in told.stdout
    assert "<svg" in page.read_text() and ElementTree.parse(picture).getroot().tag.endswith("svg")
    row = next(out.glob("results/*.parquet"))
    assert row.stat().st_size > 0
    again = trajopt("campaign", "run", *words, "--out", out)
    assert again.returncode == 2 and "holds a campaign already" in again.stderr


def test_motions_become_bundles_arrays_and_experience(tmp_path: Path) -> None:
    out = tmp_path / "few"
    words = ("random", "--robot", "planar2", "--count", 3, "--workers", 1, "--attempts", 2)
    assert trajopt("campaign", "run", *words, "--out", out).returncode == 0
    told = json.loads(trajopt("campaign", "report", out, "--json").stdout)
    assert told["whole"]["rows"] == 3 and told["beside"] is None
    data = tmp_path / "set.npz"
    told = trajopt("campaign", "dataset", out, "--out", data, "--points", 8).stdout
    assert "3 motions of 2 joints at 8 points" in told
    with np.load(data) as arrays:
        key = str(arrays["ids"][0])
    kept = tmp_path / "cell.warehouse"
    told = trajopt("campaign", "remember", out, "--experience", kept).stdout
    assert "3 motions more, 3 are remembered" in told
    assert len(Warehouse(kept).experience()) == 3
    done = trajopt("campaign", "extract", out, key, "--out", tmp_path)
    assert done.returncode == 0 and "as in the row" in done.stdout
    assert trajopt("replay", tmp_path / f"{key}.trajopt").returncode == 0


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (("run", "nowhere", "--out", "x"), "no folder, generator or installed problem named 'nowhere'"),
        (("run", "random", "--out", "x"), "random needs a robot"),
        (("run", "perturbed", "--robot", "planar2", "--out", "x"), "give --scene and --request"),
        (("run", "planar_fold", "--out", "x", "--methods", "chom"), "did you mean 'chomp'"),
        (("run", "planar_fold", "--out", "x", "--address", "auto"), "add --engine ray"),
        (("status", "nowhere"), "holds no campaign"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(words: tuple[str, ...], complaint: str, tmp_path: Path) -> None:
    done = trajopt("campaign", *words, folder=tmp_path)
    assert done.returncode == 2 and complaint in done.stderr
