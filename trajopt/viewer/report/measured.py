"""The subject of a report, and its motion measured over time in common units."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cached_property

import numpy as np

from trajopt.files.bundle import Bundle, Holds
from trajopt.files.bundle.bundle import versions
from trajopt.files.proof import MotionProof
from trajopt.geometry.dynamics import DynamicsQuery
from trajopt.optimise.methods import Knots, method_named, method_names
from trajopt.planning.result import Plan, Result
from trajopt.problem.problem import Problem
from trajopt.problem.tool_speed import ToolSpeed
from trajopt.robot.joints import JointLimits, effort_unit, joint_unit
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import tool_frames
from trajopt.tasks.cartesian import Followed
from trajopt.values.arrays import Bools, Floats, Value, floats, runs_of
from trajopt.values.documents.document import Node
from trajopt.values.errors import ShapeError
from trajopt.values.printed import shown_in
from trajopt.values.trajectory import Path, Trajectory
from trajopt.verify import Certificate
from trajopt.viewer.clearance import CLEARANCE_SAMPLES, REACH, ClearanceQuery
from trajopt.why.prices import Price, path_prices

SAMPLES = 401
"""Evenly spaced times at which a motion is measured: two for each point of a plot as wide as a page."""
BINDS = 0.99
"""A limit binds from this share on; timing leaves the rest for its rounding."""
GAP = 4
"""Shorter interruptions of a binding limit are ignored [samples], a hundredth of the motion."""
BESIDE = 1e-5
"""Tools' speeds are differences over twice this time [s]: short to any motion, long to the rounding."""


@dataclass(frozen=True, eq=False)
class Line(Value):
    """One curve, shape (S,), NaN for gaps."""

    name: str
    values: Floats


@dataclass(frozen=True, eq=False)
class Chart(Value):
    """Curves over the same times.

    Attributes:
        top: Larger values are not drawn; None for no cut.
    """

    title: str
    unit: str
    times: Floats
    lines: tuple[Line, ...]
    limits: tuple[tuple[float, str], ...] = ()
    top: float | None = None


@dataclass(frozen=True, eq=False)
class Binding(Value):
    """When something is at its limit."""

    name: str
    spans: tuple[tuple[float, float], ...]


@dataclass(frozen=True, eq=False)
class Peak(Value):
    """Extremes of a joint, in words and as shares of its limits."""

    joint: str
    begin: str
    end: str
    most: tuple[tuple[str, float] | None, ...]


@dataclass(frozen=True, eq=False)
class Measured(Value):
    """A measured motion."""

    charts: tuple[Chart, ...]
    bindings: tuple[Binding, ...]
    peaks: tuple[Peak, ...]


@dataclass(frozen=True, eq=False)
class _Rate(Value):
    """A derivative of the positions, or the torques, with their limits."""

    name: str
    several: str
    values: Floats
    limits: Floats
    units: tuple[str, ...]

    @property
    def limited(self) -> bool:
        return bool(np.isfinite(self.limits).any())

    @property
    def shares(self) -> Floats:
        return np.where(np.isfinite(self.limits), self.values / self.limits, np.nan)


def measured(problem: Problem, trajectory: Trajectory) -> Measured:
    """Measure a motion."""
    times = np.linspace(0.0, trajectory.duration, SAMPLES)
    rates = _rates(problem, trajectory, times)
    names, limits = problem.reduced.joint_names, problem.limits
    tools = [_tool(problem.reduced, trajectory, times, tool) for tool in _tools(problem)]
    clearance, near = _clearance(problem.reduced, trajectory)
    positions = trajectory(times)
    bindings = [
        *_of_positions(times, positions, limits),
        *(each for rate in rates for each in _of_rate(times, rate, names)),
        *(each for chart in tools for each in _of_tool(chart)),
        *_spans("clearance, at its margin", clearance.times, near),
    ]
    charts = (
        *_position_charts(problem, times, positions),
        *(_rate_chart(times, rate, names) for rate in rates if rate.limited),
        *tools,
        *([clearance] if clearance.lines else []),
    )
    bindings.sort(key=lambda item: -sum(end - begin for begin, end in item.spans))
    return Measured(charts, tuple(bindings), tuple(_peaks(problem, positions, rates)))


def _rates(problem: Problem, trajectory: Trajectory, times: Floats) -> tuple[_Rate, ...]:
    limits, model = problem.limits, problem.scene.robot.model
    velocities, accelerations = trajectory(times, 1), trajectory(times, 2)
    positions = trajectory(times)
    names = problem.reduced.joint_names

    def units(order: int) -> tuple[str, ...]:
        return tuple(joint_unit(model, name, order=order) for name in names)

    torques = DynamicsQuery.loaded(problem.reduced).torque(positions, velocities, accelerations)
    efforts = tuple(effort_unit(model, name) for name in names)
    return (
        _Rate("velocity", "velocities", velocities, limits.velocity, units(1)),
        _Rate("acceleration", "accelerations", accelerations, limits.acceleration, units(2)),
        _Rate("jerk", "jerks", trajectory(times, 3), limits.jerk, units(3)),
        _Rate("torque", "torques", torques, limits.effort, efforts),
    )


def _position_charts(problem: Problem, times: Floats, positions: Floats) -> Iterator[Chart]:
    names, model = problem.reduced.joint_names, problem.scene.robot.model
    for unit in ("rad", "m"):
        name, size = shown_in(unit)
        lines = tuple(
            Line(joint, size * positions[:, column])
            for column, joint in enumerate(names)
            if joint_unit(model, joint) == unit
        )
        if lines:
            yield Chart("Joint positions", name, times, lines)


def _rate_chart(times: Floats, rate: _Rate, names: Sequence[str]) -> Chart:
    shares = 100.0 * rate.shares
    lines = tuple(
        Line(name, shares[:, column]) for column, name in enumerate(names) if np.isfinite(rate.limits[column])
    )
    bounds = ((100.0, "limit"), (-100.0, "limit"))
    return Chart(f"Joint {rate.several}", "% of the limit", times, lines, bounds)


def _tools(problem: Problem) -> tuple[ToolSpeed, ...]:
    limited = problem.tool_speeds
    named = {each.frame for each in limited}
    free = [frame for frame in tool_frames(problem.reduced) if frame not in named]
    return (*limited, *(ToolSpeed(frame, np.inf, np.inf, np.zeros(3)) for frame in free))


def _tool(reduced: ReducedModel, trajectory: Trajectory, times: Floats, tool: ToolSpeed) -> Chart:
    joint, where = reduced.attachment(tool.frame)
    point = where * tool.offset
    query = ClearanceQuery(reduced, trajectory.duration)

    def at(moments: Floats) -> Floats:
        seen = query.query.kinematics(query.positions(moments, trajectory(moments)))
        return seen.rotation[:, joint] @ point + seen.translation[:, joint]

    before = np.maximum(times - BESIDE, 0.0)
    after = np.minimum(times + BESIDE, trajectory.duration)
    speed = np.linalg.norm(at(after) - at(before), axis=1) / (after - before)
    limits = ((tool.linear, "limit"),) if np.isfinite(tool.linear) else ()
    return Chart(f"Speed of {tool.frame}", "m/s", times, (Line(tool.frame, speed),), limits)


def _clearance(reduced: ReducedModel, trajectory: Trajectory) -> tuple[Chart, Bools]:
    query = ClearanceQuery(reduced, trajectory.duration)
    times = np.linspace(0.0, trajectory.duration, CLEARANCE_SAMPLES)
    found = query.smallest(times, trajectory(times), REACH)
    lines = tuple(
        Line(kind.value, np.where(np.isfinite(values), 1e3 * values, np.nan))
        for kind, values in found.items()
    )
    pairs = query.reduced.pairs
    required = [float(value) for value in np.unique(pairs.required)]
    margins = [float(value) for value in np.unique(pairs.margin) if value not in required]
    limits = (
        *((1e3 * value, "required" if value else "contact") for value in required),
        *((1e3 * value, "margin") for value in margins),
    )
    smallest = np.min([REACH * np.ones(len(times)), *found.values()], axis=0)
    top = 5.0 * max(0.01, *(limit / 1e3 for limit, _ in limits), float(smallest.min())) if limits else REACH
    least = min(margins, default=0.0)
    chart = Chart("Smallest clearance", "mm", times, lines, limits, 1e3 * min(top, REACH))
    return chart, smallest <= least / BINDS


def _of_positions(times: Floats, positions: Floats, limits: JointLimits) -> Iterator[Binding]:
    for column, name in enumerate(limits.joint_names):
        lower, upper = float(limits.lower[column]), float(limits.upper[column])
        if not np.isfinite(lower) or not np.isfinite(upper):
            continue
        left = (1.0 - BINDS) * (upper - lower)
        yield from _spans(f"{name}: lower position limit", times, positions[:, column] < lower + left)
        yield from _spans(f"{name}: upper position limit", times, positions[:, column] > upper - left)


def _of_rate(times: Floats, rate: _Rate, names: Sequence[str]) -> Iterator[Binding]:
    for column, name in enumerate(names):
        yield from _spans(f"{name}: {rate.name}", times, np.abs(rate.shares[:, column]) >= BINDS)


def _of_tool(chart: Chart) -> Iterator[Binding]:
    for limit, _ in chart.limits:
        yield from _spans(
            f"{chart.lines[0].name}: speed", chart.times, chart.lines[0].values >= BINDS * limit
        )


def _spans(name: str, times: Floats, at: Bools) -> Iterator[Binding]:
    if not at.any():
        return
    at = at.copy()
    for first, last in runs_of(~at).tolist():
        if last - first < GAP and first > 0 and last < len(at):
            at[first:last] = True
    half = float(times[1] - times[0]) / 2.0
    spans = tuple(
        (max(float(times[first]) - half, 0.0), min(float(times[last - 1]) + half, float(times[-1])))
        for first, last in runs_of(at).tolist()
    )
    yield Binding(name, spans)


def _peaks(problem: Problem, positions: Floats, rates: Sequence[_Rate]) -> Iterator[Peak]:
    model = problem.scene.robot.model
    for column, name in enumerate(problem.reduced.joint_names):
        unit, size = shown_in(joint_unit(model, name))
        ends = [f"{size * float(positions[row, column]) + 0.0:.1f} {unit}" for row in (0, -1)]
        yield Peak(name, ends[0], ends[1], tuple(_most(rate, column) for rate in rates))


def _most(rate: _Rate, column: int) -> tuple[str, float] | None:
    if not np.isfinite(rate.limits[column]):
        return None
    unit, size = shown_in(rate.units[column])
    most = float(np.abs(rate.values[:, column]).max())
    return f"{amount(size * most)} {unit}", most / float(rate.limits[column])


def amount(value: float) -> str:
    """Return a number as people write it: 0.169, 93.7, 257,000."""
    return f"{value:.3g}" if abs(value) < 1000.0 else f"{float(f'{value:.3g}'):,.0f}"


Reported = Result | Plan | Problem | Bundle | Followed


@dataclass(frozen=True, eq=False, kw_only=True)
class Subject(Value):
    """The subject of a report.

    Attributes:
        certificate: The judge's verdict on the motion, computed here.
        words: Sentence next to the verdict; may be empty.
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
    proof: MotionProof | None = None
    words: str = ""

    @property
    def status(self) -> str:
        return self.answer["status"].text("")

    @property
    def verified(self) -> bool:
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
    """Return the subject of a report; a motion of a bundle is judged again, and its prices are computed."""
    if isinstance(what, Bundle):
        return _of_bundle(what)
    if isinstance(what, Followed):
        return replace(subject_of(what.result), words=what.reason)
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
        proof=bundle.proof,
    )


def _prices(bundle: Bundle) -> tuple[Price, ...]:
    path, method = bundle.path_planned, bundle.method
    known = method in method_names() and isinstance(method_named(method), Knots)
    if path is None or len(path.knots) != bundle.problem.knots or not known:
        return ()
    return path_prices(bundle.problem, path.knots, seconds=True)
