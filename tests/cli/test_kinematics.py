"""`trajopt sample` and `trajopt reach` as processes."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.cli.process import trajopt
from tests.robots_for_tests import ODD_ARM
from trajopt.lab.reach import ReachMap, read_table


@pytest.fixture(scope="module")
def urdf(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("sample") / "odd.urdf"
    path.write_text(ODD_ARM)
    return path


def test_sample(urdf: Path) -> None:
    out = urdf.parent / "table.npz"
    words = ("--robot", urdf, "--frame", "tip", "--count", 200, "--all", "--out", out)
    done = trajopt("sample", *words, "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    table = read_table(out)
    assert told["rows"] == len(table) == 200 and told["clear"] == int(table.clear.sum())
    again = trajopt("sample", *words)
    assert "200 configurations of all with tip" in again.stdout
    np.testing.assert_array_equal(read_table(out).positions, table.positions)


def test_reach(urdf: Path) -> None:
    words = ("--robot", urdf, "--frame", "tip", "--count", 500, "--cell", 0.1)
    out, picture = urdf.parent / "map.npz", urdf.parent / "map.png"
    done = trajopt("reach", *words, "--out", out, "--picture", picture)
    assert done.returncode == 0, done.stderr
    assert "tip of odd reaches" in done.stdout and picture.stat().st_size > 10_000
    assert ReachMap.load(out).drawn == 500


def test_bad_input_is_one_line(urdf: Path) -> None:
    for words, told in (
        (("sample", "--robot", urdf, "--out", urdf.parent / "t.csv"), "written as .parquet or .npz"),
        (("sample", "--robot", urdf, "--frame", "tpi", "--out", urdf.parent / "t.npz"), "did you mean 'tip'"),
        (("reach", "--robot", urdf, "--group", "arm"), "no group named 'arm'"),
        (("reach", "--robot", urdf, "--count", 10, "--cell", 1e-9), "cell: is 1e-09 m, which gives "),
        (("reach", "--robot", urdf, "--directions", 10**12), "directions: must be at most 10000"),
    ):
        done = trajopt(*words)
        assert done.returncode == 2 and told in done.stderr and done.stderr.count("\n") == 1
