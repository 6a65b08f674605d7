"""Changes of a problem by an amount, and remedies found by planning."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from trajopt.optimise.terms.joint_positions import without_followers
from trajopt.planning.result import Result
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import During, FramePlacement, GoalSet, JointPositions, Requirement
from trajopt.robot.joints import effort_unit, joint_unit
from trajopt.scene.clearances import ROOM
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError
from trajopt.values.placement import Placement
from trajopt.values.printed import in_length, in_unit

LEAST = 1e-6
"""A margin that can shrink by less is not offered [m]."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ProblemChange:
    """One modification.

    Attributes:
        what: The modified item, as a phrase.
        unit: Unit of the amount: "m", "rad", "Nm", "kg", "" for a share.
        first: A likely sufficient amount, by the elastic relaxation; > 0.
        words: Describes the change by an amount.
        apply: Returns the problem changed by an amount.
        whole: Whether the change has no intermediate amounts; its amount is then 1.
    """

    what: str
    unit: str
    first: float
    largest: float
    words: Callable[[float], str]
    apply: Callable[[float], Problem]
    whole: bool = False


def with_requirement(problem: Problem, old: Requirement, new: Requirement) -> Problem:
    """Return the problem with one requirement replaced by another, everywhere."""
    if isinstance(problem.goal, GoalSet):
        raise ProblemError("the goal is a set: use one of the problem's alternatives")

    def swapped(items: Sequence[Requirement]) -> tuple[Requirement, ...]:
        return tuple(new if item is old else item for item in items)

    return replace(
        problem,
        goal=swapped(problem.goals),
        waypoints={
            name: swapped(items)
            for name, items in zip(problem.waypoint_names, problem.waypoint_requirements, strict=True)
        },
        constraints=tuple(
            During(new, item.after, item.until)
            if isinstance(item, During) and item.required is old
            else new
            if item is old
            else item
            for item in problem.constraints
        ),
    )


def moved_placement(problem: Problem, goal: FramePlacement, shift: Floats, first: float) -> ProblemChange:
    """Return the change that moves a placement along a direction, shape (3,), in its reference."""
    direction = _as_printed(shift)
    unit = direction / np.linalg.norm(direction)
    at = "goal" if any(item is goal for item in problem.goals) else "place"

    def apply(amount: float) -> Problem:
        where = Placement(goal.placement.rotation, goal.placement.translation + amount * unit)
        return with_requirement(problem, goal, replace(goal, placement=where))

    return ProblemChange(
        what=f"place of {goal.frame}",
        unit="m",
        first=first,
        largest=max(4.0 * first, 0.1),
        words=lambda amount: f"move the {at} of {goal.frame} {in_length(amount)} along {_axis(direction)}",
        apply=apply,
    )


def moved_joint_goal(problem: Problem, moved: Floats) -> ProblemChange:
    """Return the change that moves a goal of all joints along a direction in joint space, shape (n,).

    Its tolerances and other kinds of goals stay.
    """
    names, most = problem.reduced.joint_names, float(np.abs(moved).max())

    def apply(amount: float) -> Problem:
        shift = dict(zip(names, (moved * (amount / most)).tolist(), strict=True))
        goals = without_followers(problem.goals, problem.reduced)
        return replace(problem, goal=[_shifted(item, shift) for item in goals])

    return ProblemChange(
        what="goal",
        unit="rad",
        first=most,
        largest=2.0 * most,
        words=lambda amount: f"move the goal: {joint_moves(problem, moved * (amount / most))}",
        apply=apply,
    )


def _shifted(item: Requirement, shift: Mapping[str, float]) -> Requirement:
    if not isinstance(item, JointPositions):
        return item
    positions = {joint: value + shift.get(joint, 0.0) for joint, value in item.positions.items()}
    return replace(item, positions=positions)


def moved_start(problem: Problem, moved: Floats) -> ProblemChange:
    """Return the change that moves the start along a direction in joint space, shape (n,)."""
    most = float(np.abs(moved).max())
    index = problem.scene.robot.index(problem.reduced.joint_names)

    def apply(amount: float) -> Problem:
        start = np.array(problem.start_positions)
        start[index] += moved * (amount / most)
        return replace(problem, start=start)

    return ProblemChange(
        what="start",
        unit="rad",
        first=most,
        largest=2.0 * most,
        words=lambda amount: f"move the start: {joint_moves(problem, moved * (amount / most))}",
        apply=apply,
    )


def slower_start(problem: Problem) -> ProblemChange:
    """Return the change that takes a share off the velocity and acceleration of a start in motion."""

    def apply(amount: float) -> Problem:
        slower = {name: (1.0 - amount) * rate for name, rate in problem.start_velocity.items()}
        eased = {name: (1.0 - amount) * rate for name, rate in problem.start_acceleration.items()}
        return replace(problem, start_velocity=slower, start_acceleration=eased)

    return ProblemChange(
        what="speed of the start",
        unit="",
        first=0.5,
        largest=1.0,
        words=lambda amount: f"start at {100.0 * (1.0 - amount):.6g} % of the speed",
        apply=apply,
    )


def moved_object(problem: Problem, name: str, direction: Floats, first: float) -> ProblemChange:
    """Return the change that moves an object of the scene along a direction of the world, shape (3,)."""
    item, printed = problem.scene.object(name), _as_printed(direction)
    along = printed / np.linalg.norm(printed)

    def apply(amount: float) -> Problem:
        where = Placement(item.placement.rotation, item.placement.translation + amount * along)
        return replace(problem, scene=problem.scene.move(name, where))

    return ProblemChange(
        what=f"place of {name}",
        unit="m",
        first=first,
        largest=max(4.0 * first, 0.3),
        words=lambda amount: f"move {name} {in_length(amount)} along {_axis(printed)}",
        apply=apply,
    )


def smaller_margin(problem: Problem, first: str, second: str, lack: float) -> ProblemChange | None:
    """Return the change that reduces the margin of a pair; None without effect.

    Only the part of a margin above the required clearance can be reduced.
    """
    margin, required = problem.scene.margin_of(first, second), problem.scene.clearance_of(first, second)
    largest = margin - (required + ROOM if required > 0.0 else 0.0)
    if largest <= LEAST:
        return None

    def words(amount: float) -> str:
        return f"margin of {first} from {second} {1000 * margin:.3g} to {1000 * (margin - amount):.6g} mm"

    return ProblemChange(
        what=f"margin of {first} from {second}",
        unit="m",
        first=min(max(lack, 0.1 * margin), largest),
        largest=largest,
        words=words,
        apply=lambda amount: replace(
            problem, scene=problem.scene.with_margin(max(margin - amount, 0.0), first, second)
        ),
    )


def smaller_clearance(problem: Problem, first: str, second: str, lack: float) -> ProblemChange | None:
    """Return the change that reduces clearance and margin of a pair; None without a clearance."""
    scene = problem.scene
    margin, required = scene.margin_of(first, second), scene.clearance_of(first, second)
    if required <= 0.0:
        return None

    def words(amount: float) -> str:
        change = f"from {1000 * required:.3g} to {1000 * (required - amount):.6g} mm"
        return f"required clearance between {first} and {second} lowered {change}"

    def apply(amount: float) -> Problem:
        lower = scene.with_clearance(max(required - amount, 0.0), first, second)
        return replace(problem, scene=lower.with_margin(max(margin - amount, 0.0), first, second))

    return ProblemChange(
        what=f"required clearance between {first} and {second}",
        unit="m",
        first=min(max(lack, 0.1 * required), required),
        largest=required,
        words=words,
        apply=apply,
    )


def stronger_joint(problem: Problem, joint: str, need: float) -> ProblemChange:
    """Return the change that raises a joint's effort limit [Nm | N].

    Args:
        need: Its load at rest [Nm | N].
    """
    robot = problem.scene.robot
    place = robot.joint_names.index(joint)
    limit, unit = float(robot.limits.effort[place]), effort_unit(robot.model, joint)

    def apply(amount: float) -> Problem:
        effort = np.array(robot.limits.effort)
        effort[place] = limit + amount
        stronger = replace(robot, limits=replace(robot.limits, effort=effort))
        return replace(problem, scene=replace(problem.scene, robot=stronger))

    return ProblemChange(
        what=f"effort limit of {joint}",
        unit=unit,
        first=1.1 * max(need - limit, 0.05 * limit),
        largest=20.0 * limit,
        words=lambda amount: f"effort limit of {joint} {limit:.3g} to {limit + amount:.6g} {unit}",
        apply=apply,
    )


def lighter_load(problem: Problem, name: str) -> ProblemChange:
    """Return the change that makes a carried object lighter [kg]."""
    item = problem.scene.object(name)

    def apply(amount: float) -> Problem:
        objects = {**problem.scene.objects, name: replace(item, mass=max(item.mass - amount, 0.0))}
        return replace(problem, scene=replace(problem.scene, objects=objects))

    return ProblemChange(
        what=f"mass of {name}",
        unit="kg",
        first=item.mass / 2.0,
        largest=item.mass,
        words=lambda amount: f"mass of {name} {item.mass:.3g} to {item.mass - amount:.6g} kg",
        apply=apply,
    )


def _as_printed(direction: Floats) -> Floats:
    """Round a direction to what `_axis` prints, so that the words lead to the place planned for."""
    unit = direction / np.linalg.norm(direction)
    return np.round(unit, 0 if np.abs(unit).max() > 0.999 else 2) + 0.0


def _axis(direction: Floats) -> str:
    main = int(np.argmax(np.abs(direction)))
    if np.count_nonzero(direction) == 1:
        return f"{'+' if direction[main] > 0.0 else '-'}{'xyz'[main]}"
    return "(" + ", ".join(f"{part:.2f}" for part in direction) + ")"


def joint_moves(problem: Problem, moved: Floats) -> str:
    model, names = problem.scene.robot.model, problem.reduced.joint_names
    order = (int(k) for k in np.argsort(-np.abs(moved), kind="stable") if abs(moved[k]) > 5e-4)
    units = [joint_unit(model, name) for name in names]
    signs = ["+" if step > 0.0 else "" for step in moved.tolist()]
    return ", ".join(f"{names[k]} by {signs[k]}{in_unit(float(moved[k]), units[k])}" for k in order)


MOST = 3
"""Most remedies."""
DOUBLINGS = 4
"""Number of doublings of an insufficient amount."""
HALVINGS = 8
"""Number of halvings of a sufficient amount before the change counts as unnecessary."""
BISECTIONS = 3
"""Steps between an insufficient and a sufficient amount, at most twice as large."""

Plan = Callable[[Problem], Result]


@dataclass(frozen=True, eq=False, kw_only=True)
class Remedy:
    """A change that makes a problem solvable, while half of it does not: both were planned."""

    words: str
    what: str
    amount: float
    unit: str
    problem: Problem
    result: Result
    half: Result

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data."""
        return {
            "words": self.words,
            "what": self.what,
            "amount": self.amount,
            "unit": self.unit,
            "half": self.half.reason,
        }

    def __str__(self) -> str:
        return self.words


def smallest_changes(changes: Iterable[ProblemChange], plan: Plan) -> tuple[Remedy, ...]:
    """Try changes, the most promising first, until some make the problem solvable."""
    found: list[Remedy] = []
    for change in changes:
        if len(found) == MOST:
            break
        remedy = _Search(change, plan).smallest()
        if remedy is not None:
            found.append(remedy)
    return tuple(found)


@dataclass(eq=False)
class _Search:
    """Search of the smallest sufficient amount of one change; every amount is planned once."""

    change: ProblemChange
    plan: Plan
    planned: dict[float, Result] = field(default_factory=dict[float, Result])

    def smallest(self) -> Remedy | None:
        """Double until sufficient, halve until not, bisect, round, and check both again."""
        enough = self._enough()
        if enough is not None and not self.change.whole:
            enough = self._smaller(enough)
        if enough is None or self._solves(enough / 2.0):
            return None
        return Remedy(
            words=self.change.words(enough),
            what=self.change.what,
            amount=enough,
            unit=self.change.unit,
            problem=self._result(enough).problem,
            result=self._result(enough),
            half=self._result(enough / 2.0),
        )

    def _smaller(self, enough: float) -> float | None:
        for _ in range(HALVINGS):
            if not self._solves(enough / 2.0):
                break
            enough /= 2.0
        else:
            return None
        enough = self._bisected(enough)
        rounded = min(_rounded_up(enough), self.change.largest)
        return rounded if self._solves(rounded) else enough

    def _enough(self) -> float | None:
        amount = min(self.change.first, self.change.largest)
        for _ in range(DOUBLINGS):
            if self._solves(amount):
                return amount
            if amount >= self.change.largest:
                return None
            amount = min(2.0 * amount, self.change.largest)
        return amount if self._solves(amount) else None

    def _bisected(self, enough: float) -> float:
        """Bisect the smallest sufficient amount, half of which is insufficient."""
        short = enough / 2.0
        for _ in range(BISECTIONS):
            middle = (short + enough) / 2.0
            if self._solves(middle):
                enough = middle
            else:
                short = middle
        return enough

    def _solves(self, amount: float) -> bool:
        return self._result(amount).verified

    def _result(self, amount: float) -> Result:
        if amount not in self.planned:
            self.planned[amount] = self.plan(self.change.apply(amount))
        return self.planned[amount]


def _rounded_up(amount: float) -> float:
    digit = 10.0 ** (np.floor(np.log10(amount)) - 1.0)
    return float(np.ceil(amount / digit - 1e-9) * digit)
