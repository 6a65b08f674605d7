"""Policies behind the guard, beside a check of each waypoint and a clamp: contacts, actions passed, CPU.

python -m benchmarks.guard [--episodes 1008] [--seed 0] [--page FILE]

In each episode one of six policies drives one of three robots for 3 s among 10 to 20 random obstacles, of
which in every second episode three move. Every 0.5 s the policy emits 50 actions at 50 Hz. The driven motion
is examined every 2 ms by Coal, pair by pair, apart from guard and judge; MuJoCo also simulates the one behind
the guard. A contact counts if the robot moves.
The guard drives each episode twice; the lesser CPU time of each decision counts.
The two other guards drive the straight line from action to action: the clamp limits each step to the largest
velocities; the check of waypoints holds the last clear one instead of an action that is in collision.
"""

import argparse
from collections import Counter, defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from tests.oracles.query import PlainQuery
from trajopt.driving import IdealExecutor
from trajopt.driving.guard import Guard
from trajopt.geometry import Contacts
from trajopt.optimise.methods.timing import with_jerk
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Bools, Floats

ROBOTS = {"panda": ("panda_arm", "ready"), "ur5": ("manipulator", "up"), "xarm7": ("xarm7", "hold-up")}
"""Robots with the group that the policy moves, and the state from which it starts."""
RATE, CHUNK, EPISODE, REPLY = 50.0, 50, 3.0, 0.5
"""Actions per second, actions of a chunk, duration of an episode, and time from chunk to chunk [s]."""
SLOWEST = 1e-6
"""Largest speed of a robot at rest [rad/s]."""
CYCLE, SAMPLE, COARSE = 0.02, 2e-3, 5e-3
"""Control cycle, and samples of driven motions and of chunks that may be safe [s]."""
REPLIES = round(REPLY * RATE)
GOALS = 5
"""Random goals that are tried by the planned policy, which rests if there is a plan to none."""
SIMULATED = "guard, in MuJoCo"
PASSED = 1e-3
"""Largest deviation of the commanded positions from an action that was passed [rad]."""
NOISE, FAST = 2e-3, 1.5
"""Standard deviation of noisy actions [rad]; speed of policies that do not plan [rad/s]."""
Policy = Callable[[Floats, float], tuple[Any, float]]
"""From positions and time to actions and the age of their observation [s]."""


@dataclass(frozen=True)
class Cell:
    """A robot among obstacles, at rest in a clear configuration.

    Attributes:
        scene: Robot and obstacles.
        group: The group that the policy moves.
        start: Positions of the group's joints.
        reduced: The group's model in the scene.
        plain: Distances by Coal, pair by pair.
    """

    scene: to.Scene
    group: str
    start: Floats
    reduced: ReducedModel
    plain: PlainQuery

    @staticmethod
    def random(name: str, rng: np.random.Generator, *, moving: bool) -> "Cell":
        """Return a random cell whose start is clear by 20 mm."""
        robot, (group, state) = to.load(name), ROBOTS[name]
        cell = Cell.of(to.Scene(robot), group, robot.positions(state))
        alone, count = cell.pairs_near(cell.start, 0.02), int(rng.integers(10, 21))
        while len(cell.scene.objects) < count:
            larger = cell.scene.add(f"thing {len(cell.scene.objects)}", *_thing(rng))
            if moving and len(cell.scene.objects) < 3:
                larger = _moving(cell.scene, rng)
            found = Cell.of(larger, group, robot.positions(state))
            if found.pairs_near(found.start, 0.02) == alone:
                cell = found
        return cell

    @staticmethod
    def of(scene: to.Scene, group: str, positions: Floats) -> "Cell":
        """Return the cell of a scene."""
        reduced = reduce_model(scene, group, positions)
        start = positions[scene.robot.index(reduced.joint_names)]
        whole = reduced if reduced.timed is None else reduced.timed.reduced
        return Cell(scene, group, start, reduced, PlainQuery(whole))

    def touching(self, rows: Floats, times: Floats) -> Bools:
        """Return which configurations, shape (S, n), touch something."""
        found = self._closer(rows, times, 0.0)
        touch = np.zeros(len(rows), dtype=np.bool_)
        touch[found.sample[found.distance < 0.0]] = True
        return touch

    def pairs_near(self, positions: Floats, distance: float) -> int:
        """Return how many pairs are nearer than a distance [m] at time 0."""
        found = self._closer(positions[None], np.zeros(1), distance)
        return int((found.distance < distance).sum())

    def _closer(self, rows: Floats, times: Floats, distance: float) -> Contacts:
        timed = self.reduced.timed
        at = rows if timed is None else timed.positions(rows, times)
        return self.plain.close_pairs(at, np.full(len(self.plain.reduced.pairs.required), distance + 1e-6))


def _thing(rng: np.random.Generator) -> tuple[to.Sphere | to.Box, to.Placement]:
    angle, radius = rng.uniform(-np.pi, np.pi), rng.uniform(0.3, 0.9)
    place = to.placement((radius * np.cos(angle), radius * np.sin(angle), rng.uniform(-0.1, 1.0)))
    size = rng.uniform(0.03, 0.12)
    return (
        to.Sphere(size) if rng.random() < 0.5 else to.Box(*(2.0 * size * rng.uniform(0.5, 1.0, 3)))
    ), place


def _moving(scene: to.Scene, rng: np.random.Generator) -> to.Scene:
    shape, place = _thing(rng)
    there = to.placement(tuple(place.translation + rng.uniform(-1.0, 1.0, 3)))
    track = to.Track.through([0.0, 2.0 * EPISODE], [place, there])
    return scene.add(f"thing {len(scene.objects)}", shape, motion=track)


def planned(cell: Cell, rng: np.random.Generator) -> Policy:
    """Return the policy that follows a time-optimal plan at half its speed, and then rests."""
    limits, here = cell.reduced.limits, cell.start
    motion: to.Trajectory | None = None
    for _ in range(GOALS):
        goal = np.clip(here + rng.uniform(-1.0, 1.0, len(here)), limits.lower, limits.upper)
        still = cell.scene.still_at(0.0) if cell.scene.changing else cell.scene
        problem = to.Problem(
            scene=still, group=cell.group, start=dict(zip(cell.reduced.joint_names, here, strict=True)),
            goal=dict(zip(cell.reduced.joint_names, goal, strict=True)),
        )  # fmt: skip
        if (motion := to.plan(problem, seconds=1.0).trajectory) is not None:
            break
    followed = motion or _resting(cell)

    def act(positions: Floats, time: float) -> tuple[Any, float]:
        return followed(np.minimum((time + _ahead()) / 2.0, followed.duration)), 0.0

    return act


def _resting(cell: Cell) -> to.Trajectory:
    rows = np.tile(cell.start, (2, 1))
    return to.Trajectory(cell.reduced.joint_names, np.array((0.0, 1.0)), rows)


def noisy(cell: Cell, rng: np.random.Generator) -> Policy:
    """Return the planned policy with noise on each number."""
    exact = planned(cell, rng)

    def act(positions: Floats, time: float) -> tuple[Any, float]:
        actions = np.asarray(exact(positions, time)[0])
        return actions + NOISE * rng.standard_normal(actions.shape), 0.0

    return act


def late(cell: Cell, rng: np.random.Generator) -> Policy:
    """Return the planned policy, whose inference takes 0 to 1.5 s."""
    exact = planned(cell, rng)

    def act(positions: Floats, time: float) -> tuple[Any, float]:
        age = min(rng.uniform(0.0, 1.5), time)
        return exact(positions, time - age)[0], age

    return act


def straight(cell: Cell, rng: np.random.Generator) -> Policy:
    """Return the policy that goes straight to random goals, through everything."""
    limits = cell.reduced.limits
    low, high = np.maximum(limits.lower, -2.5), np.minimum(limits.upper, 2.5)
    goal = rng.uniform(low, high)

    def act(positions: Floats, time: float) -> tuple[Any, float]:
        move = goal - positions
        share = np.minimum(FAST * _ahead() / max(np.abs(move).max(), 1e-9), 1.0)
        return positions + share[:, None] * move, 0.0

    return act


def network(cell: Cell, rng: np.random.Generator) -> Policy:
    """Return a random network from positions and time to velocities."""
    joints = len(cell.start)
    first, second = rng.normal(size=(32, joints + 2)), rng.normal(size=(joints, 32)) / 4.0

    def act(positions: Floats, time: float) -> tuple[Any, float]:
        rows = list[Floats]()
        for ahead in _ahead():
            seen = np.concatenate((positions, (np.sin(3.0 * (time + ahead)), np.cos(3.0 * (time + ahead)))))
            positions = positions + FAST * np.tanh(second @ np.tanh(first @ seen)) / RATE
            rows.append(positions)
        return np.array(rows), 0.0

    return act


def broken(cell: Cell, rng: np.random.Generator) -> Policy:
    """Return a random network that also emits no numbers, wrong sizes and jumps."""
    moves = network(cell, rng)

    def act(positions: Floats, time: float) -> tuple[Any, float]:
        actions, age = moves(positions, time)
        kind = int(rng.integers(4))
        if kind == 0:
            actions[rng.integers(CHUNK), rng.integers(len(cell.start))] = rng.choice((np.nan, np.inf))
        elif kind == 1:
            actions = actions[:, :-1]
        elif kind == 2:
            actions[rng.integers(CHUNK) :] += rng.uniform(-2.0, 2.0)
        return actions, age

    return act


POLICIES: dict[str, Callable[[Cell, np.random.Generator], Policy]] = {
    "planned": planned, "with noise": noisy, "late": late, "straight": straight, "random network": network,
    "broken": broken,
}  # fmt: skip


def _ahead() -> Floats:
    return np.arange(1, CHUNK + 1) / RATE


@dataclass
class Tally:
    """Episodes of one policy.

    Attributes:
        episodes: Number of episodes.
        contacts: Episodes with a contact of the moving robot, by guard.
        actions: Actions that were due before the next chunk.
        passed: Of these, those that were commanded within `PASSED`.
        safe: Of these, those of safe chunks.
        safe_passed: Of these, those that were commanded within `PASSED`.
        outcomes: Decisions of the guard.
        seconds: CPU times of the decisions about chunks, by their outcome [s].
    """

    episodes: int = 0
    contacts: Counter[str] = field(default_factory=Counter[str])
    actions: int = 0
    passed: int = 0
    safe: int = 0
    safe_passed: int = 0
    outcomes: Counter[str] = field(default_factory=Counter[str])
    seconds: list[tuple[str, float]] = field(default_factory=list[tuple[str, float]])


def is_safe(cell: Cell, state: Floats, time: float, actions: Floats) -> bool:
    """Return whether straight lines from a state through a chunk keep the limits and touch nothing."""
    limits, rows = with_jerk(cell.reduced.limits), np.concatenate((state[:1], actions))
    speeds = np.concatenate((state[1:2], RATE * np.diff(rows, axis=0)))
    changes = np.concatenate((state[2:], RATE * np.diff(speeds, axis=0)))
    jerks = RATE * np.diff(changes, axis=0)
    rates = ((speeds, limits.velocity), (changes, limits.acceleration), (jerks, limits.jerk))
    if any((np.abs(rate) > most).any() for rate, most in rates):
        return False
    if (actions < limits.lower).any() or (actions > limits.upper).any():
        return False
    times: Floats = np.linspace(0.0, CHUNK / RATE, round(CHUNK / RATE / COARSE), endpoint=False)
    before = np.minimum((RATE * times).astype(np.int64), CHUNK - 1)
    fine = rows[before] + (RATE * times - before)[:, None] * (rows[before + 1] - rows[before])
    return not cell.touching(fine, time + times).any()


def guarded(cell: Cell, policy: Policy, tally: Tally) -> to.Trajectory:
    """Drive an episode behind the guard, and return the driven motion."""
    arm = IdealExecutor(cell.reduced.joint_names, cell.start)
    guard = Guard(cell.scene, cell.group, arm)
    due = list[tuple[float, Floats, bool]]()
    states, times = list[Floats](), list[float]()
    for cycle in range(round(EPISODE / CYCLE)):
        if cycle % round(REPLY / CYCLE) == 0:
            actions, age = policy(arm.state().positions, arm.now())
            decision = guard.act(actions, rate=RATE, stamp=arm.now() - age)
            tally.outcomes[decision.outcome.name] += 1
            tally.seconds.append((decision.outcome.name, guard.seconds["act"][-1]))
            if np.shape(actions) == (CHUNK, len(cell.start)) and not age:
                kept = is_safe(cell, guard.committed(arm.now()), arm.now(), actions)
                soon = zip(_ahead()[:REPLIES], actions[:REPLIES], strict=True)
                due += ((arm.now() + ahead, action, kept) for ahead, action in soon)
        guard.tick()
        for _ in range(round(CYCLE / SAMPLE)):
            states.append(guard.committed(arm.now()))
            times.append(arm.now())
            while due and due[0][0] <= arm.now() + 1e-9:
                at, action, kept = due.pop(0)
                passed = bool(np.abs(guard.committed(at)[0] - action).max() <= PASSED)
                tally.actions += 1
                tally.passed += passed
                tally.safe += kept
                tally.safe_passed += kept and passed
            arm.advance(SAMPLE)
    orders = np.array(states)[:, :3].swapaxes(0, 1)
    return to.Trajectory(cell.reduced.joint_names, np.array(times) - times[0], *orders)


def touches(cell: Cell, driven: to.Trajectory) -> bool:
    """Return whether the robot touches something while it moves."""
    moves = np.abs(driven(driven.times, 1)).max(axis=1) > SLOWEST
    return bool(cell.touching(driven.positions[moves], driven.times[moves]).any())


def touches_in_simulation(cell: Cell, driven: to.Trajectory) -> bool:
    """Return whether the first contact with an object in MuJoCo begins while the robot moves.

    An object that ran into the robot at rest stays in contact when the robot goes on.
    """
    begun = defaultdict[frozenset[str], float](lambda: np.inf)
    for each in to.simulate(cell.reduced, driven).collisions:
        things = frozenset(each.pair) - set(cell.scene.robot.links)
        begun[things] = min(begun[things], each.start)
    within = [time for time in begun.values() if time <= driven.duration]
    return any(float(np.abs(driven(time, 1)).max()) > SLOWEST for time in within)


def clamped(cell: Cell, here: Floats, action: Floats, time: float) -> Floats:
    """Return the next position: at most at the largest velocities."""
    most = cell.reduced.limits.velocity / RATE
    return here + np.clip(action - here, -most, most)


def checked_waypoint(cell: Cell, here: Floats, action: Floats, time: float) -> Floats:
    """Return the next position: the action, clamped, if that is clear; else the last one."""
    there = clamped(cell, here, action, time)
    return here if cell.touching(there[None], np.array((time,)))[0] else there


def stepped(cell: Cell, policy: Policy, step: Callable[[Cell, Floats, Floats, float], Floats]) -> bool:
    """Drive an episode from action to action; return whether the moving robot touches something."""
    here, rows, times = cell.start, list[Floats](), list[float]()
    fine = np.arange(0.0, 1.0, SAMPLE * RATE)
    for reply in range(round(EPISODE / REPLY)):
        now = reply * REPLY
        actions, age = policy(here, now)
        if np.shape(actions) != (CHUNK, len(here)) or not np.isfinite(actions).all():
            continue  # the driver refuses them
        begin = round(age * RATE)
        for number, action in enumerate(actions[begin : begin + REPLIES]):
            time = now + number / RATE
            there = step(cell, here, action, time + 1.0 / RATE)
            if np.abs(there - here).max() > 0.0:
                rows += list(here + fine[:, None] * (there - here))
                times += list(time + fine / RATE)
            here = there
    return bool(rows) and bool(cell.touching(np.array(rows), np.array(times)).any())


OTHERS = {"check of waypoints": checked_waypoint, "clamp": clamped}


def episode(number: int, seed: int, tallies: dict[str, Tally]) -> None:
    """Drive one episode behind each guard."""
    kinds, robots = list(POLICIES), list(ROBOTS)
    kind, robot = kinds[number % len(kinds)], robots[number // len(kinds) % len(robots)]
    moving = number // (len(kinds) * len(robots)) % 2 == 1
    cell = Cell.random(robot, np.random.default_rng((seed, number)), moving=moving)
    tally = tallies[f"{kind}, {'moving' if moving else 'still'}"]
    tally.episodes += 1

    def policy() -> Policy:
        return POLICIES[kind](cell, np.random.default_rng((seed, number, 1)))

    begun, again = len(tally.seconds), Tally()
    driven = guarded(cell, policy(), tally)
    tally.contacts["guard"] += touches(cell, driven)
    tally.contacts[SIMULATED] += touches_in_simulation(cell, driven)
    guarded(cell, policy(), again)
    for place, (_, seconds) in enumerate(again.seconds, begun):
        outcome, first = tally.seconds[place]
        tally.seconds[place] = outcome, min(first, seconds)
    for name, step in OTHERS.items():
        tally.contacts[name] += stepped(cell, policy(), step)


def section(tallies: dict[str, Tally]) -> str:
    """Return the table."""
    head = (
        "policy, obstacles",
        "episodes",
        "with a contact: guard",
        SIMULATED,
        *OTHERS,
        "actions passed",
        "of safe chunks",
        "decisions",
    )
    rows = list[tuple[str, ...]]()
    for name, tally in tallies.items():
        outcomes = ", ".join(f"{count} {outcome}" for outcome, count in tally.outcomes.most_common())
        touched = (str(tally.contacts[each]) for each in ("guard", SIMULATED, *OTHERS))
        shares = _share(tally.passed, tally.actions), _share(tally.safe_passed, tally.safe)
        rows.append((name, str(tally.episodes), *touched, *shares, outcomes.lower()))
    return f"{table(head, rows)}\n\n{_cpu(tallies)}"


def _share(part: int, whole: int) -> str:
    return f"{part / whole:.2%}" if whole else "-"


def _cpu(tallies: dict[str, Tally]) -> str:
    """Return the table of CPU times: of decisions that pass the actions, and of all."""
    rows = list[tuple[str, ...]]()
    for obstacles in ("still", "moving"):
        timed = [
            each for name, tally in tallies.items() if name.endswith(obstacles) for each in tally.seconds
        ]
        for which, names in (("passed as given", {"AS_GIVEN"}), ("all", {name for name, _ in timed})):
            spent = 1e3 * np.array([seconds for name, seconds in timed if name in names])
            if len(spent):
                p50, p99 = np.percentile(spent, (50, 99))
                rows.append((obstacles, which, str(len(spent)), f"{p50:.1f}", f"{p99:.1f}"))
    return table(("obstacles", "decisions about 50 actions", "number", "CPU p50 [ms]", "p99 [ms]"), rows)


def main() -> None:
    """Drive the episodes, and print or write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--episodes", type=int, default=1008)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--page", type=Path, help="write the table into this page")
    given = parser.parse_args()
    tallies = defaultdict[str, Tally](Tally)
    for number in range(given.episodes):
        episode(number, given.seed, tallies)
    written = section(dict(sorted(tallies.items())))
    print(written)
    if given.page is not None:
        write_section(given.page, "guard", written)


if __name__ == "__main__":
    main()
