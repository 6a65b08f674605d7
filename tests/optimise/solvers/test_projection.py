"""Projection: rows hold afterwards, by the nearest change in the metric."""

import numpy as np
import pytest
from scipy.optimize import LinearConstraint, minimize

from tests.optimise.solvers.plane import KNOTS, PlaneNlp, straight
from trajopt.optimise.nlp import Linearisation
from trajopt.optimise.solvers.covariant import LinearRows, into_bounds, smooth_metric
from trajopt.values.arrays import Floats


def linearised(nlp: PlaneNlp, x: Floats) -> Linearisation:
    return nlp.linearise(x, nlp.sampling(x, fine=False))


def test_a_free_end_is_brought_to_the_goal_and_fields_are_left_alone() -> None:
    nlp = PlaneNlp(goal_free=True)
    metric = smooth_metric(nlp.lower < nlp.upper, nlp.scale)
    x = straight() * 0.8
    step = LinearRows.around(linearised(nlp, x), metric).project(np.zeros_like(x))
    assert (x + step)[-1] == pytest.approx([1.0, 0.0], abs=1e-5)
    assert step[0] == pytest.approx([0.0, 0.0])


def test_a_step_within_the_bounds_is_not_changed() -> None:
    nlp = PlaneNlp(band=0.1)
    metric = smooth_metric(nlp.lower < nlp.upper, nlp.scale)
    step = 0.09 * metric.draw(np.random.default_rng(1)) / 4.0
    assert np.abs(step[:, 1]).max() < 0.1
    assert LinearRows.around(linearised(nlp, straight()), metric).project(step) == pytest.approx(step)


def test_the_nearest_step_in_the_metric() -> None:
    """Independent: scipy's minimiser of the metric's distance under the same rows."""
    nlp = PlaneNlp(goal_free=True)
    x = straight() * 0.9
    metric = smooth_metric(nlp.lower < nlp.upper, nlp.scale)
    rows = LinearRows.around(linearised(nlp, x), metric)
    wanted = 0.1 * metric.draw(np.random.default_rng(3))
    found = rows.project(wanted)
    weight = np.linalg.inv(metric.inverse[1][1:, 1:])

    def distance(height: Floats) -> float:
        away = height - wanted[1:, 1]
        return float(away @ weight @ away)

    last = (np.arange(KNOTS - 1) == KNOTS - 2).astype(float)[None, :]
    best = minimize(
        distance, wanted[1:, 1], jac=lambda h: 2.0 * weight @ (h - wanted[1:, 1]), method="SLSQP",
        constraints=LinearConstraint(last, 0.0, 0.0), options={"ftol": 1e-14, "maxiter": 500},
    )  # fmt: skip
    assert found[1:, 1] == pytest.approx(best.x, abs=1e-4)


def test_bounds_are_kept_without_a_kink() -> None:
    nlp = PlaneNlp()
    metric = smooth_metric(nlp.lower < nlp.upper, nlp.scale)
    x = straight()
    x[:, 1] = 0.5 * np.sin(np.linspace(0.0, np.pi, KNOTS))
    upper = nlp.upper.copy()
    upper[1:-1, 1] = 0.3
    bent = into_bounds(x, nlp.lower, upper, metric)
    assert (bent <= upper).all() and bent[:, 1].max() == pytest.approx(0.3)
    kink = np.abs(np.diff(bent[:, 1], n=2)).max()
    assert kink < np.abs(np.diff(np.minimum(x[:, 1], 0.3), n=2)).max()
