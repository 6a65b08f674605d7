"""Robots led among 20 boxes, by the servo and by mink's kinematics, on the same streams of commands.

python -m benchmarks.servo [--seeds 5] [--seconds 6] [--page FILE]

Equal terms: the same robot, boxes, pairs that must keep apart, twists and rate; mink has its own limits of
positions and velocities and its own collision avoidance, which keeps as much distance as the servo does, and
its default QP solver. It knows no limits of acceleration and jerk. Joints that state no jerk limit have that
of the servo, the whole acceleration in 0.1 s. Both drive an ideal robot. What comes of it is measured in the
same way, from positions and velocities at the ticks: accelerations and jerks are differences, contacts are
MuJoCo's, and distances Coal's. Times are CPU time of a tick.

What the limits alone cost is measured as well: a robot with nothing around it and without any delay, each of
whose joints has the velocity that the twist asks of it as soon as its own limits allow. It is no bound, for
joints that wait for each other can follow a little more.
"""

import argparse
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import mink
import mujoco
import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from trajopt.driving import IdealExecutor, Player, Servo, ServoOptions, Stream, TimedOrder, Twist, guide
from trajopt.driving.servo_input import Order
from trajopt.driving.servo_task import Tool
from trajopt.geometry import Query
from trajopt.optimise.methods.timing import with_jerk
from trajopt.problem.problem import Problem
from trajopt.problem.requirements.joints import LENGTH
from trajopt.scene.reducing import tool_frame
from trajopt.simulation.spec import describe
from trajopt.values.arrays import Floats
from trajopt.verify import Judge

ROBOTS = {
    "panda": ("panda_arm", "ready"),
    "ur5": ("manipulator", {"shoulder_lift_joint": -1.2, "elbow_joint": 1.5, "wrist_2_joint": -1.2}),
}
PERIOD = 0.01
BOXES, EDGE, ROOM = 20, 0.1, 0.05
"""Boxes around the arm, their edges, and how far from the arm as it begins they are at least [m]."""
SILENT = 0.1
"""Share of twists that are replaced by silence."""
DETECTED = 0.05
"""From so near on mink keeps bodies apart [m]: a robot at 0.5 m/s comes 5 mm nearer in a tick."""
KEPT = 0.8
"""mink leaves out, by a rule of its own, the first link and what is fixed to the world: 20 pairs of 365 of a
Panda, 40 of 313 of a UR5. Were there fewer, it would not be told right what to keep apart."""
ROUNDING = 1e-3
"""Limits are broken by more than this share of themselves; positions by as many radians or metres."""
FINE = 10
"""Steps of a tick in which joints follow within their limits."""
DAMPED = 1e-3
"""Damping of the pseudo-inverse that converts a twist to joint velocities [m]."""
KINDS = ("position", "velocity", "acceleration", "jerk")
WAYS = ("trajopt", "mink", "limits alone")


@dataclass(frozen=True)
class Hand:
    """How somebody leads a robot.

    Attributes:
        fastest: Largest twist along each axis [m/s].
        turning: Largest about each [rad/s].
        lasts: Least and most time for which a twist is said [s].
    """

    fastest: float
    turning: float
    lasts: tuple[float, float]


HANDS = {"brisk": Hand(0.3, 1.0, (0.2, 0.8)), "calm": Hand(0.1, 0.3, (1.0, 3.0))}


@dataclass
class Tally:
    """What became of the runs of one way.

    Attributes:
        seconds: CPU time of each tick [s].
        broken: For each limit, whether it was broken in each tick.
        distances: Smallest distance in each tick [m].
        contacts: Whether MuJoCo has a contact, in each tick.
        asked: How far the tool was asked to go [m].
        gone: How far along that it went [m].
    """

    seconds: list[float] = field(default_factory=list[float])
    broken: dict[str, list[bool]] = field(default_factory=lambda: {kind: [] for kind in KINDS})
    distances: list[float] = field(default_factory=list[float])
    contacts: list[bool] = field(default_factory=list[bool])
    asked: float = 0.0
    gone: float = 0.0

    def row(self) -> list[str]:
        """The row of the table."""
        found = 1e3 * np.percentile(self.seconds, (50.0, 99.0, 99.9))
        share = [f"{np.mean(self.broken[kind]):.1%}" for kind in KINDS]
        below = np.array(self.distances) < 0.0
        return [
            str(len(self.seconds)),
            *(f"{each:.2f}" for each in found),
            *share,
            f"{np.mean(self.contacts):.1%}",
            f"{np.mean(below):.1%}",
            f"{1e3 * min(self.distances):.1f}",
            f"{self.gone / self.asked:.0%}",
        ]


def crowded(name: str, rng: np.random.Generator) -> Problem:
    """Put boxes around an arm."""
    group, start = ROBOTS[name]
    problem = Problem(scene=to.Scene(to.load(name)), group=group, start=start, goal=start)
    while len(problem.scene.objects) < BOXES:
        angle, away, height = rng.uniform(-np.pi, np.pi), rng.uniform(0.3, 0.8), rng.uniform(0.0, 0.9)
        where = to.placement((away * np.cos(angle), away * np.sin(angle), height))
        scene = problem.scene.add(f"box {len(problem.scene.objects)}", to.Box(EDGE, EDGE, EDGE), where)
        wide = problem.scene.add("wide", to.Box(*[EDGE + 2.0 * ROOM] * 3), where)
        if Judge(replace(problem, scene=wide).reduced).examine(problem.reduced.start_positions).clear:
            problem = replace(problem, scene=scene)
    return problem


def spoken(rng: np.random.Generator, seconds: float, hand: Hand) -> Stream:
    """Draw a stream of twists."""
    said, at = list[TimedOrder](), 0.0
    while at < seconds:
        lasts = float(rng.uniform(*hand.lasts))
        along, about = (
            rng.uniform(-hand.fastest, hand.fastest, 3),
            rng.uniform(-hand.turning, hand.turning, 3),
        )
        if rng.uniform() > SILENT:
            said.append(TimedOrder(Order(command=Twist(along, about)), at, min(at + lasts - PERIOD, seconds)))
        at += lasts
    return Stream(said)


def by_servo(problem: Problem, stream: Stream, ticks: int) -> Iterator[tuple[Floats, Floats, float]]:
    """Yield positions and velocities at each tick, and its CPU time [s]."""
    arm = IdealExecutor(problem.reduced.joint_names, problem.reduced.start_positions)
    servo = Servo(arm, problem, ServoOptions(period=PERIOD))
    rows: list[tuple[Floats, Floats]] = []

    def each(_: Servo) -> None:
        rows.append(tuple(arm.committed(arm.now())[:2]))  # pyright: ignore[reportArgumentType]

    guide(servo, _Endless(stream), arm.advance, longest=ticks * PERIOD, each=each)
    for (positions, velocities), seconds in zip(rows, servo.seconds, strict=True):
        yield positions, velocities, seconds


class _Endless(Player):
    """A stream with silence after its end."""

    @property
    def done(self) -> bool:
        return False


def by_mink(problem: Problem, stream: Stream, ticks: int) -> Iterator[tuple[Floats, Floats, float]]:
    """Yield positions and velocities at each tick, and its CPU time [s]."""
    reduced, kept = problem.reduced, ServoOptions(period=PERIOD).clearance
    report = describe(reduced)
    joint, held = reduced.attachment(tool_frame(reduced))
    body = report.spec.joint(reduced.model.names[joint]).parent
    x, y, z, w = held.quaternion
    body.add_site(name="tool", pos=held.translation, quat=np.array((w, x, y, z)))
    model = report.spec.compile()
    # The model names its pairs one by one; mink asks the geometries' own types too, and drops all otherwise.
    model.geom_contype[:] = model.geom_conaffinity[:] = 1
    pairs = [([pair.geomname1], [pair.geomname2]) for pair in report.spec.pairs]
    apart = mink.CollisionAvoidanceLimit(
        model, pairs, minimum_distance_from_collisions=kept, collision_detection_distance=DETECTED
    )
    if len(apart.geom_id_pairs) < KEPT * len(pairs):
        raise RuntimeError(f"mink keeps {len(apart.geom_id_pairs)} of {len(pairs)} pairs apart")
    limits = (
        mink.ConfigurationLimit(model),
        mink.VelocityLimit(
            model, dict(zip(reduced.joint_names, problem.limits.velocity.tolist(), strict=True))
        ),
        apart,
    )
    task = mink.FrameTask("tool", "site", position_cost=1.0, orientation_cost=LENGTH, lm_damping=1e-6)
    configuration, played = mink.Configuration(model, reduced.start_positions.copy()), Player(stream)
    velocity = np.zeros(model.nv)
    for tick in range(ticks):
        order = played.read(tick * PERIOD)
        begun, positions = time.process_time(), configuration.q.copy()
        here = configuration.get_transform_frame_to_world("tool", "site")
        wrist = np.zeros(6)
        if order is not None and isinstance(order.command, Twist):
            wrist = np.concatenate((order.command.linear, order.command.angular))
        turned = mink.SO3.exp(PERIOD * wrist[3:]) @ here.rotation()
        there = here.translation() + PERIOD * wrist[:3]
        task.set_target(mink.SE3.from_rotation_and_translation(turned, there))
        try:
            velocity = mink.solve_ik(configuration, [task], PERIOD, "daqp", limits=limits)
        except mink.NoSolutionFound:
            velocity = np.zeros(model.nv)
        configuration.integrate_inplace(velocity, PERIOD)
        yield positions, velocity, time.process_time() - begun


def by_limits(problem: Problem, stream: Stream, ticks: int) -> Iterator[tuple[Floats, Floats, float]]:
    """Yield positions and velocities at each tick, and no time."""
    reduced, limits, played = problem.reduced, with_jerk(problem.limits), Player(stream)
    query, frame, step = Query(reduced), tool_frame(reduced), PERIOD / FINE
    q = reduced.start_positions.copy()
    v, a = np.zeros_like(q), np.zeros_like(q)
    for tick in range(ticks):
        yield q.copy(), v.copy(), 0.0
        order, asked = played.read(tick * PERIOD), np.zeros(6)
        if order is not None and isinstance(order.command, Twist):
            asked = np.concatenate((order.command.linear, LENGTH * order.command.angular))
        jacobian = Tool.at(query, q, frame, len(q)).jacobian
        wanted = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + DAMPED**2 * np.eye(6), asked)
        wanted /= max(1.0, float((np.abs(wanted) / limits.velocity).max()))
        for _ in range(FINE):
            # The velocity that is left to gain where the acceleration is let go of says which way to jerk.
            left = wanted - v - a * np.abs(a) / (2.0 * limits.jerk)
            jerk = np.clip((left / step - a) / step, -limits.jerk, limits.jerk)
            jerk = np.clip(jerk, (-limits.acceleration - a) / step, (limits.acceleration - a) / step)
            q = q + step * (v + step * (a / 2.0 + step * jerk / 6.0))
            v, a = v + step * (a + step * jerk / 2.0), a + step * jerk


def count(
    tally: Tally, problem: Problem, stream: Stream, rows: Sequence[tuple[Floats, Floats, float]]
) -> None:
    """Measure a run."""
    reduced, limits = problem.reduced, with_jerk(problem.limits)
    query, frame = Query(reduced), tool_frame(reduced)
    model = describe(reduced).spec.compile()
    data, played = mujoco.MjData(model), Player(stream)
    positions, velocities = (np.array([row[which] for row in rows]) for which in (0, 1))
    # What is commanded in a tick holds until the next: changes are spread over a tick.
    accelerations = np.diff(velocities, axis=0, prepend=0.0) / PERIOD
    jerks = np.diff(accelerations, axis=0, prepend=0.0) / PERIOD
    inside = np.maximum(limits.lower - positions, positions - limits.upper).max(axis=1)
    tally.broken["position"] += (inside > ROUNDING).tolist()
    for kind, rates, most in (
        ("velocity", velocities, limits.velocity),
        ("acceleration", accelerations, limits.acceleration),
        ("jerk", jerks, limits.jerk),
    ):
        tally.broken[kind] += (np.abs(rates) > most * (1.0 + ROUNDING)).any(axis=1).tolist()
    wide = np.full(len(reduced.pairs.first), 1.0)
    for tick, place in enumerate(positions):
        near = query.close_pairs(place[None], wide).distance
        tally.distances.append(float(near.min()) if len(near) else 1.0)
        data.qpos[:] = place
        mujoco.mj_forward(model, data)
        tally.contacts.append(bool(data.ncon))
        order = played.read(tick * PERIOD)
        if order is not None and isinstance(order.command, Twist) and tick + 1 < len(positions):
            at = [
                problem.scene.placement_of(frame, reduced.all_positions(each)).translation
                for each in positions[tick : tick + 2]
            ]
            speed = float(np.linalg.norm(order.command.linear))
            tally.asked += speed * PERIOD
            tally.gone += float((at[1] - at[0]) @ order.command.linear) / speed
    tally.seconds += [row[2] for row in rows]


def page(tallies: dict[tuple[str, str], dict[str, Tally]]) -> str:
    """Return the section of the page."""
    heads = [
        "", "ticks", "median [ms]", "p99", "p99.9", *(f"ticks beyond {kind}" for kind in KINDS),
        "in contact (MuJoCo)", "below 0 (Coal)", "nearest [mm]", "followed",
    ]  # fmt: skip
    rows = [
        [f"{way}, {', '.join(names)}", *tally.row()]
        for names, ways in tallies.items()
        for way, tally in ways.items()
        if way != "limits alone"
    ]
    alone = [
        [f"{', '.join(names)}", *(f"{ways[way].gone / ways[way].asked:.0%}" for way in (WAYS[2], WAYS[0]))]
        for names, ways in tallies.items()
    ]
    followed = table(["followed", "joint limits alone", "trajopt, with boxes"], alone)
    return "\n".join((table(heads, rows), "", followed))


def main(words: Sequence[str] | None = None) -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5, help="scenes and streams of each robot")
    parser.add_argument("--seconds", type=float, default=6.0, help="of each stream")
    parser.add_argument("--page", type=Path)
    asked = parser.parse_args(words)
    tallies = {(name, hand): {way: Tally() for way in WAYS} for name in ROBOTS for hand in HANDS}
    ticks = round(asked.seconds / PERIOD)
    for (name, hand), ways in tallies.items():
        for seed in range(asked.seeds):
            rng = np.random.default_rng(seed)
            problem = crowded(name, rng)
            stream = spoken(rng, asked.seconds, HANDS[hand])
            free = replace(problem, scene=to.Scene(problem.scene.robot))
            for way, drive, led in zip(
                WAYS, (by_servo, by_mink, by_limits), (problem, problem, free), strict=True
            ):
                count(ways[way], led, stream, list(drive(led, stream, ticks)))
    text = page(tallies)
    print(text)
    if asked.page is not None:
        write_section(asked.page, "servo", text)


if __name__ == "__main__":
    main()
