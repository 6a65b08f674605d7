"""CasADi's plugins on small programs with known answers, without a robot."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from trajopt.optimise.methods.casadi.nlpsol import CasadiProgram, Nlpsol
from trajopt.optimise.solvers.solver import Iteration, SolverStatus
from trajopt.values.arrays import Floats
from trajopt.values.errors import SolverNotFound

PLUGINS = {
    "ipopt": Nlpsol("ipopt"),
    "fatrop": Nlpsol("fatrop"),
    "sqpmethod": Nlpsol("sqpmethod", {"qpsol": "piqp", "qpsol_options": {"error_on_fail": False}}),
}


def hs071() -> CasadiProgram:
    x = ca.MX.sym("x", 4)
    return CasadiProgram(
        x,
        x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2],
        ca.vertcat(x[0] * x[1] * x[2] * x[3], ca.sumsqr(x)),
        np.ones(4),
        np.full(4, 5.0),
        np.array((25.0, 40.0)),
        np.array((np.inf, 40.0)),
    )


def disc(radius: float) -> CasadiProgram:
    x = ca.MX.sym("x", 2)
    objective = (1 - x[0]) ** 2 + 100 * (x[1] - x[0] ** 2) ** 2
    side = np.full(2, 10.0)
    return CasadiProgram(
        x, objective, ca.sumsqr(x), -side, side, np.full(1, -np.inf), np.full(1, radius * abs(radius))
    )


def solved(name: str, program: CasadiProgram, x0: Floats) -> Floats:
    result = PLUGINS[name].solve(program, x0)
    assert result.status is SolverStatus.CONVERGED, result.said
    return result.x


@pytest.mark.parametrize("name", PLUGINS)
def test_hock_schittkowski_71(name: str) -> None:
    x = solved(name, hs071(), np.array((1.0, 5.0, 5.0, 1.0)))
    assert x == pytest.approx([1.0, 4.74299963, 3.82114998, 1.37940829], abs=1e-5)


@pytest.mark.parametrize("name", PLUGINS)
def test_rosenbrock_in_a_disc(name: str) -> None:
    assert solved(name, disc(2.0), np.array((0.5, 0.5))) == pytest.approx([1.0, 1.0], abs=1e-4)
    assert solved(name, disc(1.0), np.array((0.5, 0.5))) == pytest.approx([0.7864, 0.6177], abs=1e-3)


@pytest.mark.parametrize("name", PLUGINS)
def test_an_infeasible_program_is_not_a_success(name: str) -> None:
    assert PLUGINS[name].solve(disc(-1.0), np.array((2.0, 1.0))).status is not SolverStatus.CONVERGED


@pytest.mark.parametrize("name", ["ipopt", "sqpmethod"])
def test_elastic_bounds_give_way_where_nothing_holds_them(name: str) -> None:
    """x^2 + y^2 <= -1 is exceeded least at the origin; the log says by how much, without the slack."""
    program = replace(disc(-1.0), elastic=np.ones(1, dtype=np.bool_))
    solver = replace(PLUGINS[name], penalty=1e4)
    result = solver.solve(program, np.array((0.3, 0.2)))
    assert result.x == pytest.approx([0.0, 0.0], abs=2e-3)
    assert result.log[-1].violation == pytest.approx(1.0, abs=1e-3)
    assert result.log[-1].cost == pytest.approx(1.0, abs=1e-2)


@pytest.mark.parametrize("name", ["ipopt", "sqpmethod"])
def test_elastic_bounds_hold_where_they_can(name: str) -> None:
    program = replace(disc(1.0), elastic=np.ones(1, dtype=np.bool_))
    result = replace(PLUGINS[name], penalty=100.0).solve(program, np.array((0.5, 0.5)))
    assert result.x == pytest.approx([0.7864, 0.6177], abs=1e-3)


@pytest.mark.parametrize("name", ["ipopt", "sqpmethod"])
def test_without_curvature_the_answer_is_the_same(name: str) -> None:
    result = replace(PLUGINS[name], curvature=False).solve(disc(2.0), np.array((0.5, 0.5)))
    assert result.x == pytest.approx([1.0, 1.0], abs=1e-4)


def test_a_plugin_that_reports_has_a_log_that_ends_at_the_answer() -> None:
    seen: list[Iteration] = []
    result = PLUGINS["ipopt"].solve(hs071(), np.array((1.0, 5.0, 5.0, 1.0)), progress=seen.append)
    assert tuple(seen) == result.log and len(seen) > 3
    assert seen[-1].cost == pytest.approx(17.0140173, abs=1e-5)
    assert seen[-1].violation == pytest.approx(0.0, abs=1e-6)


def test_other_plugins_are_refused() -> None:
    with pytest.raises(SolverNotFound, match="ipopt"):
        Nlpsol("ipop")
