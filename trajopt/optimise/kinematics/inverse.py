"""Inverse kinematics: configurations that hold a goal, nearest first, or why there are none."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from trajopt.geometry import Evaluator, evaluator
from trajopt.optimise.kinematics.projection import ANYWHERE, Projection, turning_joints
from trajopt.optimise.kinematics.validity import Validity, count_of, requirements_of, validity
from trajopt.optimise.terms.joint_positions import joint_box
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import Requirement
from trajopt.robot.joints import JointLimits, draw_positions
from trajopt.scene.bounds import largest_gravity_torques
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Ints, Value, floats, one_of, readonly
from trajopt.values.errors import ProblemError, SolverNotFound
from trajopt.values.errors.arguments import checked


class InverseMethod(Protocol):
    """A method of inverse kinematics."""

    @property
    def name(self) -> str:
        """Its name in `INVERSE_METHODS`."""
        ...

    def search(self, projection: Projection) -> Callable[[Floats], Floats] | None:
        """Return a function that moves starts, (S, n) -> (S, n), to candidates; None for projection alone.

        The caller moves them into the limits and measures their violation.

        Raises:
            RequirementNotSupported: If the method cannot state a requirement.
        """
        ...


@dataclass(frozen=True)
class LevenbergMarquardt:
    """Levenberg-Marquardt on a batch of starts (`Projection`); it takes every requirement."""

    name = "levenberg-marquardt"

    @checked
    def search(self, projection: Projection) -> None:
        del projection


def _placo() -> InverseMethod:
    from trajopt.optimise.kinematics.placo import Placo  # the package takes a while to import

    return Placo()


INVERSE_METHODS: Mapping[str, Callable[[], InverseMethod]] = {
    "levenberg-marquardt": LevenbergMarquardt,
    "placo": _placo,
}
"""Name of each method of inverse kinematics -> factory with default options."""


def inverse_method(method: str | InverseMethod) -> InverseMethod:
    if not isinstance(method, str):
        return method
    if method not in INVERSE_METHODS:
        raise SolverNotFound("inverse-kinematics method", method, INVERSE_METHODS)
    return INVERSE_METHODS[method]()


STARTS = 64
"""Starts of a search; twice as many cost a third more time."""
MANY_STARTS = 1024
"""Starts before the search fails: some goals are reached from one start in five hundred."""
WAVES = 3
"""Most waves of starts while no solution is free; without any, the last one seeks near bounds too."""
PUSHES = 3
"""Most waves around the solutions with the shallowest collisions, while none is free."""
PUSH = 0.8
"""Standard deviation of these starts [rad | m]; 0.2 to 0.8 find about as much."""
SAME = 1e-2
"""Solutions that differ by less in every joint are one [rad | m]."""
AS_FAR = 0.01
"""Relative difference of travel times that count as equal: acceleration is ignored."""
HOLDABLE = 1.0 - 2e-6
"""Largest share of an effort limit for holding still: the rest moves the joint."""

LEVENBERG_MARQUARDT = LevenbergMarquardt()


@dataclass(frozen=True, eq=False)
class GoalCandidates(Value):
    """Result of the search; each list is nearest to the start first.

    Attributes:
        free: Configurations that hold goal and requirements and can be held.
        blocked: Configurations that hold the goal but collide or come too near.
        blocking: The pair of owners that blocks the nearest of these, and their distance [m].
        overloaded: Clear configurations that need more torque to hold still than the effort limits allow,
            smallest excess first.
        required: Required clearance of the blocking pair [m].
        nearest: The configuration with the smallest violation, shape (n,) [rad | m].
        nearest_miss: Smallest violation of the goal if none holds it [m and rad].
    """

    free: tuple[Floats, ...]
    blocked: tuple[Floats, ...]
    blocking: tuple[str, str, float] | None
    nearest: Floats
    nearest_miss: float
    required: float = 0.0
    overloaded: tuple[Floats, ...] = ()

    @property
    def colliding(self) -> int:
        """Number of configurations that hold the goal but collide."""
        return len(self.blocked)


def goal_candidates(
    query: Evaluator,
    goals: Sequence[Requirement],
    *,
    rng: np.random.Generator,
    starts: int = STARTS,
    method: InverseMethod = LEVENBERG_MARQUARDT,
    effort: Floats | None = None,
    check: Callable[[], None] | None = None,
) -> GoalCandidates:
    """Search configurations that hold all goals.

    Args:
        rng: Draws the starts after the first, which is the start configuration.
        method: Moves starts until they hold the goals.
        effort: Effort limits for holding still, shape (n,) [Nm | N]; not considered when None.
        check: Called before every wave; may raise to stop.
    """
    reduced = query.reduced
    projection = Projection(reduced, goals, query)
    search = method.search(projection)
    box = joint_box(goals, reduced)
    narrow = is_one(box)
    begin = random_starts(reduced, rng, WAVES * starts, box)
    found = np.empty((0, begin.shape[1]))
    closest: Floats = reduced.start_positions
    nearest_miss = np.inf
    depth, pair, load = np.empty(0), np.empty(0, dtype=np.int64), np.empty(0)
    for wave in range(WAVES + PUSHES):
        if check is not None:
            check()
        if wave == WAVES - 1 and not len(found):
            projection = Projection(reduced, goals, query, ANYWHERE)
        if wave < WAVES:
            drawn = begin[wave * starts : (wave + 1) * starts]
        elif len(found) > 0:
            drawn = _around(found, depth, starts, rng.spawn(1)[0])
        else:
            break
        ended = projection(drawn) if search is None else projection.measure(search(drawn))
        least = int(ended.violation.argmin())
        if ended.violation[least] < nearest_miss:
            nearest_miss = float(ended.violation[least])
            closest = ended.positions[least]
        new = _nearest_turns(reduced, projection, ended.positions[ended.violation == 0.0])
        found = _by_travel(reduced, np.concatenate((found, new)))
        # Where all of the goal is one, a free part of it must not be dropped for one that collides.
        found = found if narrow else _distinct(found)
        depth, pair = _deepest(query, found)
        load = holding_load(query, found, effort)
        if ((depth == 0.0) & (load < HOLDABLE)).any():
            break
    collides = depth > 0.0
    blocking, least = None, 0.0
    if collides.any():
        nearest = int(np.argmax(collides))
        least = float(reduced.pairs.required[pair[nearest]])
        blocking = (*reduced.owners(int(pair[nearest])), least - float(depth[nearest]))
    heavy = ~collides & (load >= HOLDABLE)
    lightest = np.flatnonzero(heavy)[np.argsort(load[heavy], kind="stable")]
    free, blocked, overloaded = (
        _distinct(found[chosen]) for chosen in (~collides & ~heavy, collides, lightest)
    )
    return GoalCandidates(
        tuple(free), tuple(blocked), blocking, closest, nearest_miss, least, tuple(overloaded)
    )


def is_one(box: tuple[Floats, Floats]) -> bool:
    """Return whether all configurations between two bounds, shape (n,) each [rad | m], count as one."""
    return bool((box[1] - box[0] <= SAME).all())


def random_starts(
    reduced: ReducedModel,
    rng: np.random.Generator,
    count: int,
    box: tuple[Floats, Floats] | None = None,
) -> Floats:
    """Return the start configuration and others drawn evenly within the limits, shape (count, n).

    Args:
        box: Bounds to draw within, shape (n,) each [rad | m]; joints with a narrow range in it are drawn from
            all of it.
    """
    limits = reduced.limits
    if box is not None:
        room, known = box[1] - box[0], np.isfinite(box[0]) & np.isfinite(box[1])
        drawn = known & (room >= 0.0) & ((room > SAME) | bool((room <= SAME).all()))
        lower, upper = (
            np.where(drawn, side, limit)
            for side, limit in zip(box, (limits.lower, limits.upper), strict=True)
        )
        limits = replace(limits, lower=lower, upper=upper)
    begin = draw_positions(limits, count, rng=rng)
    # Without limits one place is as good as another, so a joint that slides stays near its start.
    endless = np.isinf(limits.lower) & np.isinf(limits.upper) & (turning_joints(reduced) == 0.0)
    begin[:, endless] += reduced.start_positions[endless]
    begin[0] = reduced.start_positions
    return begin


def _around(found: Floats, depth: Floats, count: int, rng: np.random.Generator) -> Floats:
    """Draw starts around the solutions that collide least: a free one is more likely there than elsewhere."""
    least = found[np.argsort(depth, kind="stable")[: max(count // 8, 1)]]
    chosen = least[np.arange(count) % len(least)]
    return chosen + rng.normal(scale=PUSH, size=chosen.shape)


def _nearest_turns(reduced: ReducedModel, projection: Projection, found: Floats) -> Floats:
    turned = nearest_turn(reduced.start_positions, found, reduced.limits, turning_joints(reduced))
    moved = np.flatnonzero((turned != found).any(axis=1))
    if len(moved) > 0:
        broken = moved[projection.violation(turned[moved]) > 0.0]
        turned[broken] = found[broken]
    return turned


def _by_travel(reduced: ReducedModel, found: Floats) -> Floats:
    """Sort by the slowest joint's time at full speed, then by total travel."""
    travel = np.abs(found - reduced.start_positions) / reduced.limits.velocity
    times = travel.max(axis=1, initial=0.0)
    order = np.argsort(times, kind="stable")
    rank, nearest = np.empty(len(found)), -np.inf
    for place in order:
        if times[place] > nearest * (1.0 + AS_FAR):
            nearest = times[place]
        rank[place] = nearest
    return found[np.lexsort((np.linalg.norm(travel, axis=1), rank))]


def _distinct(found: Floats) -> Floats:
    apart = np.abs(found[:, None] - found).max(axis=2, initial=0.0)
    kept: list[int] = []
    for place in range(len(found)):
        if not (apart[place, kept] < SAME).any():
            kept.append(place)
    return found[kept]


def _deepest(query: Evaluator, found: Floats) -> tuple[Floats, Ints]:
    pairs = query.reduced.pairs
    least = pairs.required.copy()
    for pair, allowance in pairs.allowances:
        if allowance.last > 0.0:
            least[pair] = min(least[pair], 0.0, -allowance.depth)
    contacts = query.close_pairs(found, pairs.required)
    depth, worst = np.zeros(len(found)), np.zeros(len(found), dtype=np.int64)
    lack = pairs.required[contacts.pair] - contacts.distance
    for place in np.flatnonzero(contacts.distance < least[contacts.pair]):
        sample = contacts.sample[place]
        if lack[place] > depth[sample]:
            depth[sample], worst[sample] = lack[place], contacts.pair[place]
    return depth, worst


def holding_load(query: Evaluator, positions: Floats, effort: Floats | None) -> Floats:
    """Return the largest share of an effort limit that holding still needs, shape (k,).

    Args:
        positions: Shape (k, n) [rad | m].
        effort: Of the group's joints, shape (n,) [Nm | N]; None returns zeros, as do loads within limits.
    """
    if effort is None or not (largest_gravity_torques(query.reduced) > effort).any():
        return np.zeros(len(positions))
    return (np.abs(query.dynamics.gravity(positions).torque) / effort).max(axis=1, initial=0.0)


def nearest_turn(start: Floats, goal: Floats, limits: JointLimits, revolute: Floats) -> Floats:
    """Return the goal with whole turns added, within the limits, so that each joint travels least.

    Args:
        revolute: 1 for joints that turn, 0 for joints that slide, shape (n,).
    """
    turn = 2.0 * np.pi * revolute
    best = np.array(goal)
    for count in (-1.0, 0.0, 1.0):
        turns = np.round((start - goal) / (2.0 * np.pi)) * revolute
        shifted = goal + turns * turn + count * turn
        inside = (shifted >= limits.lower) & (shifted <= limits.upper)
        outside_now = (best < limits.lower) | (best > limits.upper)
        nearer = np.abs(shifted - start) < np.abs(best - start)
        best = np.where(inside & (nearer | outside_now), shifted, best)
    return best


def goal_configurations(problem: Problem, *, rng: np.random.Generator | None = None) -> tuple[Floats, ...]:
    """Return collision-free configurations at which a motion may end: they hold goal and path constraints.

    Constraints from your own code are not considered.

    Args:
        rng: Draws the starts of the search; a fixed seed when None.

    Returns:
        Positions of the group's joints, each of shape (n,) [rad | m], nearest to the start first;
        empty if the search found none.
    """
    one_of("problem", problem, Problem)
    required = (*problem.goals, *problem.requirements_at(problem.last_stop))
    draws = np.random.default_rng(0) if rng is None else one_of("rng", rng, np.random.Generator)
    return goal_candidates(problem.evaluator(problem.reduced), required, rng=draws).free


@dataclass(frozen=True, eq=False)
class InverseSolutions(Value):
    """Result of inverse kinematics.

    Attributes:
        free: Configurations that hold the goal and touch nothing, shape (n,) each, nearest first.
        colliding: Configurations that hold the goal but collide, nearest first.
        nearest: If none is free: faults of the nearest that collides, or that came nearest to the goal.
    """

    free: tuple[Floats, ...]
    colliding: tuple[Floats, ...]
    nearest: Validity | None

    @property
    def valid(self) -> bool:
        """Whether the goal can be held without collision, as far as was found."""
        return bool(self.free)

    def explain(self) -> str:
        """Return the number of solutions, or how near the search came and the obstacle in the way."""
        if self.nearest is None:
            return f"{len(self.free)} free and {len(self.colliding)} colliding configurations found"
        why = "; ".join(self.nearest.reasons)
        if self.colliding:
            return (
                f"all {len(self.colliding)} configurations that hold the goal collide; in the nearest {why}"
            )
        return f"no configuration found that holds the goal; in the nearest {why}"


@checked
def inverse_kinematics(
    reduced: ReducedModel,
    goal: Requirement | Sequence[Requirement],
    *,
    near: ArrayLike | None = None,
    rng: np.random.Generator | None = None,
    starts: int = STARTS,
    method: str | InverseMethod = LEVENBERG_MARQUARDT.name,
) -> InverseSolutions:
    """Search configurations within limits that hold a goal: `frame_placement(...)` or any other.

    Several requirements hold together: `[frame_placement(...), joint_positions({"joint7": 0.5})]` finds
    solutions with the redundant joint at that value.

    Args:
        goal: One requirement or several; a frame may be a link, a tool frame or an attached object.
        near: Configuration to be near, shape (n,) [rad | m], by the time of the slowest joint; the model's
            start when None.
        rng: Draws the starts of the search; a fixed seed when None.
        method: "levenberg-marquardt", which takes every requirement, "placo", or your own method; results are
            always checked.

    Raises:
        ProblemError: If no goal is given.
        NameNotFound: If the goal names an unknown frame or joint.
        ShapeError: If `near` is not one finite position for each joint.
        SolverNotFound: If the method's name is unknown.
        RequirementNotSupported: If the method cannot state a requirement.
    """
    chosen = inverse_method(method)
    wanted = requirements_of(reduced, "goal", goal)
    if not wanted:
        raise ProblemError("inverse_kinematics needs a goal: frame_placement(...) or several requirements")
    at = reduced if near is None else with_start(reduced, near, "near")
    found = goal_candidates(
        evaluator(at),
        wanted,
        rng=rng or np.random.default_rng(0),
        starts=count_of("starts", starts),
        method=chosen,
    )
    nearest: Validity | None = None
    if not found.free:
        nearest = validity(at, found.blocked[0] if found.blocked else found.nearest, requirements=wanted)
    return InverseSolutions(found.free, found.blocked, nearest)


def with_start(reduced: ReducedModel, positions: ArrayLike, name: str = "positions") -> ReducedModel:
    place = floats(name, positions, (len(reduced.joint_names),))
    return replace(reduced, start=readonly(reduced.all_positions(place)))
