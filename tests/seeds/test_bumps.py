"""Bent lines keep their ends, differ from each other and repeat with the generator's seed."""

from itertools import islice

import numpy as np

from trajopt.seeds import bumps, straight_line


def test_bumps() -> None:
    line = straight_line(np.array([0.0, 1.0]), np.array([1.0, -1.0]), 9)
    scale = np.array([1.0, 0.0])
    bent = list(islice(bumps(line, scale, np.random.default_rng(5)), 4))
    for one in bent:
        assert np.array_equal(one[[0, -1]], line[[0, -1]])
        assert np.array_equal(one[:, 1], line[:, 1])
    heights = [one[2, 0] - line[2, 0] for one in bent]
    assert len(set(heights)) == 4
    again = next(bumps(line, scale, np.random.default_rng(5)))
    assert np.array_equal(again, bent[0])
