"""Scenarios of execution: a short run each, with the expected reaction.

python -m benchmarks.execution --scenarios [--page FILE]

But for the runs in MuJoCo nothing is simulated; plans take no time, unless a scenario says so.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf

import numpy as np

import trajopt as to
from benchmarks.page import table
from benchmarks.servo_scenarios import Outcome, in_contact, into_the_table, silence, stretched_out
from trajopt.driving import (
    CommittedMotion,
    EventKind,
    Fault,
    FaultKind,
    IdealExecutor,
    RunReport,
    SimulatedExecutor,
    Supervisor,
    SupervisorOptions,
    Surprise,
    Surprises,
    run,
)
from trajopt.planning import on_the_way
from trajopt.verify import Judge

CYCLE = 0.02


@dataclass(frozen=True)
class Scenario:
    """Something that can happen.

    Attributes:
        name: What happens.
        expected: What the robot is to do then.
        play: Plays it.
    """

    name: str
    expected: str
    play: Callable[[], Outcome]


class Remembering(IdealExecutor):
    """Remembers everything that it was given to do."""

    given: CommittedMotion | None = None

    def splice(self, trajectory: to.Trajectory, at: float) -> str:
        """Drive a motion from a time on; say why not."""
        self.given = self.given or CommittedMotion(self.joint_names, self.state().commanded)
        refused = super().splice(trajectory, at)
        if not refused:
            self.given.splice(trajectory, at, now=-inf)
        return refused


def cup() -> to.Problem:
    """A Panda swings around a pillar, to a cup."""
    return to.named_problem("cup_past_pillar")


def supervised(problem: to.Problem) -> tuple[Remembering, Supervisor]:
    """Return an ideal robot on its way to the goal."""
    arm = Remembering(problem.scene.robot.joint_names, problem.start_positions)
    supervisor = Supervisor(arm, problem)
    supervisor.go(problem)
    return arm, supervisor


def cycle(arm: IdealExecutor, supervisor: Supervisor, until: float) -> None:
    """Cycle until all is done, or a time [s]."""
    while supervisor.busy and arm.now() < until - 1e-9:
        supervisor.cycle()
        arm.advance(CYCLE)


def words_of(supervisor: Supervisor | RunReport, *kinds: EventKind) -> list[str]:
    """Return the words of the events of some kinds."""
    return [event.words for event in supervisor.events if event.kind in kinds]


def box_at(problem: to.Problem, motion: to.Trajectory, time: float) -> to.Placement:
    """Return where the hand is at a time of a motion [s], as the place of a box."""
    tool = "panda_hand"
    return to.placement(
        problem.scene.placement_of(tool, problem.reduced.all_positions(motion(time))).translation
    )


def appears(at: float, ahead: float) -> tuple[to.Problem, to.Scene]:
    """Return a problem, and its world with a box where the tool would be so much after a time [s]."""
    problem = cup()
    motion = to.plan(problem).require().trajectory
    where = box_at(problem, motion, at + ahead)
    return problem, problem.scene.add("box", to.Box(0.06, 0.06, 0.06), where)


def stop_possible() -> Outcome:
    """8."""
    at = 0.1
    problem, world = appears(at, 0.3)
    box = Surprise(name="box", at=at, placement=world.object("box").placement, shape=to.Box(0.06, 0.06, 0.06))
    done = run(problem, surprises=Surprises(objects=(box,)))
    did = "planned around it" if done.count(EventKind.REPLANNED) else "stopped, planned from rest"
    clear = not done.contacts and not done.count(EventKind.UNPROVEN_STOP)
    return Outcome(f"{did}; {len(done.contacts)} contacts, reached: {done.reached}", clear and done.reached)


def too_late() -> Outcome:
    """9."""
    at = 0.25
    problem, world = appears(at, 0.06)
    arm, supervisor = supervised(problem)
    cycle(arm, supervisor, at)
    supervisor.see(world)
    supervisor.cycle()
    stopping, unproven = (
        words_of(supervisor, EventKind.STOPPING),
        words_of(supervisor, EventKind.UNPROVEN_STOP),
    )
    named = bool(unproven) and "box" in unproven[0] and "mm" in unproven[0]
    return Outcome("; ".join((*stopping, *unproven)), named and len(stopping) == 1)


def reaches_in() -> Outcome:
    """10: A forearm comes in at 0.4 m/s, stays for 1.4 s and goes; it is seen twenty times a second."""
    problem = replace(cup(), velocity_scaling=0.5, acceleration_scaling=0.2)
    forearm = to.Box(0.6, 0.1, 1.0)
    out, into = (to.placement((x, 0.25, 0.5)) for x in (1.1, 0.78))
    there = to.Track.through((0.0, 0.8, 2.2, 3.1), (out, into, into, out))
    world = problem.scene.add("forearm", forearm, motion=there)
    arm = SimulatedExecutor(world, problem.start_positions)
    supervisor = Supervisor(arm, problem)

    def seen(now: float) -> to.Scene:
        """Where it is, and that it goes on so for a third of a second, more or less."""
        where, soon = there.at(now), there.at(now + 0.01)
        velocity = (soon.translation - where.translation) / 0.01
        track = to.Track.constant_velocity(where, velocity, end=0.3)
        return problem.scene.add("forearm", forearm, motion=to.Prediction(track, (0.01, 0.1, 0.0)))

    supervisor.see(seen(0.0))
    supervisor.go(problem)
    looked = 0.0
    while supervisor.busy and arm.now() < 8.0:
        if arm.now() >= looked + 0.05:
            looked = arm.now()
            supervisor.see(seen(looked))
        supervisor.cycle()
        arm.advance(CYCLE)
    kinds = [event.kind for event in supervisor.events]
    slowed, stopped = EventKind.SLOWING in kinds, EventKind.STOPPING in kinds
    resumed = stopped and EventKind.RESUMED in kinds[kinds.index(EventKind.STOPPING) :]
    words = f"slowed: {slowed}, stopped: {stopped}, resumed: {resumed}, "
    words += f"{len(arm.contacts)} contacts, at fault or not; reached after {arm.now():.2f} s"
    clear = not arm.contacts and EventKind.UNPROVEN_STOP not in kinds
    return Outcome(words, clear and slowed and resumed and kinds[-1] is EventKind.REACHED)


def off_track() -> Outcome:
    """15."""
    problem = cup()
    drift = Fault(kind=FaultKind.DRIFT, begin=0.2, end=0.4, joint="panda_joint1", size=0.02)
    arm = SimulatedExecutor(problem.scene, problem.start_positions, faults=(drift,))
    supervisor = Supervisor(arm, problem)
    supervisor.go(problem)
    while supervisor.busy and arm.now() < 3.0:
        supervisor.cycle()
        arm.advance(CYCLE)
    arm.advance(1.0)
    rests = float(np.abs(arm.truth().velocities).max()) < 1e-3
    off = words_of(supervisor, EventKind.OFF_TRACK)
    again = supervisor.recover(problem.goals[0], scaling=0.5)
    while supervisor.moving:
        supervisor.cycle()
        arm.advance(CYCLE)
    there = all(
        check.holds
        for check in Judge(problem.reduced).check(
            arm.committed(arm.now())[0][
                [arm.joint_names.index(name) for name in problem.reduced.joint_names]
            ],
            problem.goals,
        )
    )
    words = f"{off[0] if off else 'not seen'}; stopped, then recovered to the goal: {again and there}"
    return Outcome(words, len(off) == 1 and rests and again and there and not arm.contacts)


def killed() -> Outcome:
    """16."""
    problem = cup()
    path = to.plan(problem).require().trajectory(np.linspace(0.0, 10.0, 20_000))
    away: list[float] = []
    for last in np.arange(0.06, 0.6, 0.06).tolist():
        arm, supervisor = supervised(problem)
        cycle(arm, supervisor, last)
        arm.advance(5.0)
        here = arm.state().positions[problem.scene.robot.index(problem.reduced.joint_names)]
        away.append(inf if arm.state().velocities.any() else float(np.abs(path - here).max(axis=1).min()))
    return Outcome(
        f"{len(away)} times at rest, at most {1e3 * max(away):.2f} mrad off the path", max(away) < 2e-3
    )


class SlowPlanner:
    """The clock of a planner that takes 0.2 s on request, also for the robot that passes."""

    def __init__(self, arm: IdealExecutor) -> None:
        """Take the robot for which time passes."""
        self.arm, self.due = arm, False

    def __call__(self) -> float:
        """Return the time [s]."""
        if self.due:
            self.due = False
            self.arm.advance(0.2)
        return self.arm.now()


def deadlines_missed() -> Outcome:
    """17: The goal changes; each plan to it takes longer than the robot is committed ahead."""
    problem = replace(cup(), velocity_scaling=0.1, acceleration_scaling=0.02)
    arm = Remembering(problem.scene.robot.joint_names, problem.start_positions)
    clock = SlowPlanner(arm)
    options = SupervisorOptions(budget=to.Budget(seconds=30.0, clock=clock), retry=0.1)
    supervisor = Supervisor(arm, problem, options)
    supervisor.go(problem)
    cycle(arm, supervisor, 0.5)
    back = dict(zip(problem.reduced.joint_names, problem.reduced.start_positions.tolist(), strict=True))
    returns = replace(problem, goal=to.joint_positions(back))
    supervisor.go(returns)
    while supervisor.busy and arm.now() < 30.0:
        clock.due = True
        supervisor.cycle()
        arm.advance(CYCLE)
    missed = len(words_of(supervisor, EventKind.MISSED_DEADLINE))
    assert arm.given is not None
    driven = arm.given.ahead(0.0, problem.reduced.joint_names)
    assert driven is not None
    proven = to.judge(on_the_way(returns, driven, 0.0), driven).verified
    words = (
        f"missed {missed} time on the way; all that was driven is one motion, proven: {proven}; then reached"
    )
    kept = missed == 1 and proven and not words_of(supervisor, EventKind.REJECTED)
    return Outcome(words, kept and supervisor.events[-1].kind is EventKind.REACHED)


def edited_elsewhere() -> Outcome:
    """18."""
    problem = cup()
    durations: list[float] = []
    kinds: list[EventKind] = []
    for edited in (False, True):
        arm, supervisor = supervised(problem)
        cycle(arm, supervisor, 0.2)
        if edited:
            supervisor.see(problem.scene.add("far", to.Box(0.1, 0.1, 0.1), to.placement((0.0, -0.8, 0.3))))
        cycle(arm, supervisor, 10.0)
        durations.append(arm.now())
        kinds = [event.kind for event in supervisor.events]
    words = f"{durations[1]:.2f} s, {durations[0]:.2f} s without the edit"
    told = kinds == [EventKind.STARTED, EventKind.WORLD_CHANGED, EventKind.STILL_CLEAR, EventKind.REACHED]
    return Outcome(words, told and durations[0] == durations[1])


def at_full_speed() -> Outcome:
    """19: The goal is changed near peak speed; all that was driven is judged as one motion."""
    problem = cup()
    motion, replanned, proven = to.plan(problem).require().trajectory, 0, 0
    fastest = motion(np.linspace(0.0, motion.duration, 500), 1)
    peak = float(np.linspace(0.0, motion.duration, 500)[np.abs(fastest).max(axis=1).argmax()])
    for at in (peak - 0.15, peak - 0.1, peak - 0.05):
        arm, supervisor = supervised(problem)
        cycle(arm, supervisor, at)
        back = dict(zip(problem.reduced.joint_names, problem.reduced.start_positions.tolist(), strict=True))
        returns = replace(problem, goal=to.joint_positions(back))
        supervisor.go(returns)
        cycle(arm, supervisor, 10.0)
        replanned += len(words_of(supervisor, EventKind.REPLANNED))
        assert arm.given is not None
        driven = arm.given.ahead(0.0, problem.reduced.joint_names)
        assert driven is not None
        proven += to.judge(on_the_way(returns, driven, 0.0), driven).verified
    words = f"{replanned} of 3 spliced in motion, near {peak:.2f} s; {proven} of 3 proven as a whole"
    return Outcome(words, replanned == proven == 3)


def grows_uncertain() -> Outcome:
    """24: A cart next to the path is no longer observed, and may move at up to 0.4 m/s."""
    problem = cup()
    stands = to.Track.constant_velocity(to.placement((0.45, 0.75, 0.3)), (0.0, 0.0, 0.0))
    cart = to.Prediction(stands, (0.02, 0.4, 0.0))
    arm, supervisor = supervised(problem)
    cycle(arm, supervisor, 0.1)
    supervisor.see(problem.scene.add("cart", to.Box(0.3, 0.3, 0.6), motion=cart))
    cycle(arm, supervisor, 3.0)
    stale = words_of(supervisor, EventKind.STALE)
    rests = not arm.state().velocities.any()
    kinds = [event.kind for event in supervisor.events]
    named = bool(stale) and "cart" in stale[0]
    reached = EventKind.REACHED in kinds
    clear = EventKind.UNPROVEN_STOP not in kinds
    return Outcome(
        f"{'; '.join(stale)}; at rest: {rests}, reached: {reached}", named and rests and clear and not reached
    )


SCENARIOS = {
    8: Scenario("a box appears 0.3 s ahead, a stop is possible", "stop or replan; no contact", stop_possible),
    9: Scenario(
        "a box appears inside the stopping distance", "earliest stop; pair and shortfall named", too_late
    ),
    10: Scenario(
        "a person's arm reaches in and leaves",
        "slows, stops, resumes; no contact at fault",
        reaches_in,
    ),
    15: Scenario("tracking error beyond the tolerance", "stops, then is resynchronised", off_track),
    16: Scenario("the planner dies in motion", "rest at the committed stop", killed),
    17: Scenario(
        "the deadline is missed ten times running", "committed motion kept, no jump", deadlines_missed
    ),
    18: Scenario("the scene is edited away from the path", "proven again, no slowing", edited_elsewhere),
    19: Scenario("a new goal at peak speed", "spliced without a jump, limits proven", at_full_speed),
    20: Scenario("servo into the table, then away", "stops clear; leaves at full speed", into_the_table),
    21: Scenario("servo into a singularity, then away", "bounded speed, leaves freely", stretched_out),
    22: Scenario("the joystick is silent", "stops after the time-out, within limits", silence),
    23: Scenario("a fault in light contact, then home", "separates monotonically, reaches home", in_contact),
    24: Scenario(
        "the position of an object becomes uncertain", "slows to rest; object named", grows_uncertain
    ),
}


def scenarios_page() -> str:
    """Play all; return the section of the page."""
    rows: list[list[str]] = []
    for number, scenario in SCENARIOS.items():
        outcome = scenario.play()
        verdict = "yes" if outcome.expected else "**no**"
        rows.append([str(number), scenario.name, scenario.expected, outcome.happened, verdict])
    return table(["", "scenario", "expected", "result", "as expected"], rows)
