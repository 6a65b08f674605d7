"""The subject of a report: a plan, a failure or a problem, from this process or a bundle."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cached_property

import numpy as np

from trajopt.files.bundle import Bundle, Holds
from trajopt.files.bundle.bundle import versions
from trajopt.optimise.methods import Knots, method_named, method_names
from trajopt.planning.result import Plan, Result
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Floats, Value, floats
from trajopt.values.documents.document import Node
from trajopt.values.errors import ShapeError
from trajopt.values.trajectory import Path, Trajectory
from trajopt.verify import Certificate
from trajopt.why.prices import Price, path_prices

Reported = Result | Plan | Problem | Bundle
"""Possible subjects of a report."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Subject(Value):
    """The subject of a report.

    Attributes:
        holds: Its kind.
        problem: The problem.
        trajectory: The motion, verified or not, or None.
        path: The best path, or None.
        certificate: The judge's verdict on the motion, computed here.
        answer: The planning result, as by `Result.as_dict`.
        explanation: `Result.explain` as plain data.
        prices: Prices of a plan's active constraints.
        made: Time of planning or saving (UTC).
        versions: Package versions of the planner, by name.
    """

    holds: Holds
    problem: Problem
    trajectory: Trajectory | None
    path: Path | None
    certificate: Certificate | None
    answer: Node
    explanation: Node
    prices: tuple[Price, ...]
    made: str
    versions: Mapping[str, str]

    @property
    def status(self) -> str:
        """Name of the planning status; empty for an unplanned problem."""
        return self.answer["status"].text("")

    @property
    def verified(self) -> bool:
        """Whether the judge finds that the motion does all that it must."""
        return self.certificate is not None and self.certificate.verified

    @cached_property
    def blocked(self) -> Floats | None:
        """The configuration that shows the cause, shape (n,) [rad | m]."""
        return self._configuration(self.explanation["configuration"])

    @cached_property
    def nearest_free(self) -> Floats | None:
        """The nearest configuration that is free, shape (n,) [rad | m]."""
        return self._configuration(self.explanation["nearest_free"]["positions"])

    def _configuration(self, node: Node) -> Floats | None:
        if node.missing:
            return None
        try:
            return floats(node.place, np.array(node.numbers()), (len(self.problem.reduced.joint_names),))
        except ShapeError as error:
            raise node.error(str(error)) from error


def subject_of(what: Reported) -> Subject:
    """Return the subject of a report.

    A motion of a bundle is judged again, and the prices of its constraints are computed here.

    Raises:
        FileFormatError: If a bundle is invalid.
    """
    if isinstance(what, Bundle):
        return _of_bundle(what)
    problem = what if isinstance(what, Problem) else what.problem
    result = what if isinstance(what, Result) else None
    moved = None if isinstance(what, Problem) else what
    solved = isinstance(what, Plan) or (result is not None and result.verified)
    explained = None if result is None else result.explain(plan_again=result.verified)
    plan_answer = {"status": "SOLVED", "verified": True} if isinstance(what, Plan) else {}
    return Subject(
        holds=Holds.PLAN if solved else Holds.PROBLEM if result is None else Holds.FAILURE,
        problem=problem,
        trajectory=None if moved is None else moved.trajectory,
        path=None if moved is None else moved.path,
        certificate=None if moved is None else moved.certificate,
        answer=Node(plan_answer if result is None else result.as_dict(), problem.name, "answer"),
        explanation=Node({} if explained is None else explained.as_dict(), problem.name, "explanation"),
        prices=() if explained is None else explained.prices,
        made=datetime.now(UTC).isoformat(timespec="seconds"),
        versions=versions(),
    )


def _of_bundle(bundle: Bundle) -> Subject:
    certificate = None if bundle.trajectory is None else bundle.judged()
    return Subject(
        holds=bundle.holds,
        problem=bundle.problem,
        trajectory=bundle.trajectory,
        path=bundle.path_planned,
        certificate=certificate,
        answer=Node(dict(bundle.answer), str(bundle.path), "answer"),
        explanation=Node(dict(bundle.explanation), str(bundle.path), "explanation"),
        prices=_prices(bundle) if certificate is not None and certificate.verified else (),
        made=bundle.made,
        versions=bundle.versions,
    )


def _prices(bundle: Bundle) -> tuple[Price, ...]:
    """Return the prices of a motion along a path that was optimised by its knots; others have none."""
    path, method = bundle.path_planned, bundle.method
    known = method in method_names() and isinstance(method_named(method), Knots)
    if path is None or len(path.knots) != bundle.problem.knots or not known:
        return ()
    return path_prices(bundle.problem, path.knots, seconds=True)
