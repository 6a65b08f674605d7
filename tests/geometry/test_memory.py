"""A query among many things that move takes memory for what it measures, not for every three joints."""

import os
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.geometry import Query
from trajopt.scene.reducing import reduce_model

STATM = Path("/proc/self/statm")
THINGS, QUERIES = 50, 4
MOST = 100e6
"""More than a few arrays by joint would take many times over [bytes]; the cube of 150 joints is 27 MB."""


def resident() -> int:
    """Memory that is in use [bytes]."""
    return int(STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(not STATM.exists(), reason="the memory of a process is read as Linux tells it")
def test_a_query_among_many_things_is_small(planar_arm: to.Robot) -> None:
    scene = to.Scene(planar_arm)
    for number in range(THINGS):
        places = [to.placement((x, 1.0, float(number))) for x in (-1.0, 1.0)]
        scene = scene.add(f"ball {number}", to.Sphere(0.05), motion=to.Track.through([0.0, 1.0], places))
    timed = reduce_model(scene, "arm", np.zeros(len(planar_arm.joint_names))).timed
    assert timed is not None
    kept = [Query(timed.reduced)]
    before = resident()
    kept += [Query(timed.reduced) for _ in range(QUERIES)]
    rows = timed.positions(np.zeros((1, 2)), np.zeros(1))
    assert all(len(query.kinematics(rows).translation) == 1 for query in kept)
    assert resident() - before < MOST
