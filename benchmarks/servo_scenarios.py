"""Scenarios of servo control and contact: a short run each."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

import trajopt as to
from trajopt.driving import IdealExecutor, Servo, ServoOptions, Supervisor, Twist
from trajopt.values.arrays import Floats
from trajopt.verify import Judge

TICK = 0.01
SPEED = 0.2
"""Of the tool [m/s]."""


@dataclass(frozen=True)
class Outcome:
    """What became of a scenario.

    Attributes:
        happened: In a sentence.
        expected: Whether that is what is expected.
    """

    happened: str
    expected: bool


def led(scene: to.Scene) -> tuple[IdealExecutor, Servo]:
    """Return a Panda that is led by hand."""
    problem = to.Problem(scene=scene, group="panda_arm", start="ready", goal="ready")
    arm = IdealExecutor(problem.reduced.joint_names, problem.reduced.start_positions)
    return arm, Servo(arm, problem, ServoOptions(period=TICK))


def lead(arm: IdealExecutor, servo: Servo, twist: Twist, seconds: float) -> Floats:
    """Give a command in each tick; return the velocity of the tool in each, (k, 3)."""
    reduced, velocities = servo.problem.reduced, list[Floats]()

    def tool() -> Floats:
        return reduced.scene.placement_of(
            servo.frame, reduced.all_positions(arm.state().positions)
        ).translation

    for _ in range(round(seconds / TICK)):
        servo.command(twist)
        servo.tick()
        before = tool()
        arm.advance(TICK)
        velocities.append((tool() - before) / TICK)
    return np.array(velocities)


def into_the_table() -> Outcome:
    """20."""
    scene = to.Scene(to.load("panda")).add("table", to.Box(1.0, 1.0, 0.1), to.placement((0.6, 0.0, -0.06)))
    arm, servo = led(scene)
    down = lead(arm, servo, Twist(np.array((0.0, 0.0, -SPEED))), 3.5)
    clear = Judge(servo.problem.reduced).examine(arm.state().positions).clear
    up = lead(arm, servo, Twist(np.array((0.0, 0.0, SPEED))), 0.5)
    words = f"crept at {abs(down[-1, 2]):.3f} m/s, clear: {clear}; left at {up[-1, 2]:.3f} of {SPEED:g} m/s"
    crept, left = float(abs(down[-1, 2])), float(abs(up[-1, 2] - SPEED))
    return Outcome(words, clear and crept < 0.1 * SPEED and left < 0.02 * SPEED)


def stretched_out() -> Outcome:
    """21."""
    arm, servo = led(to.Scene(to.load("panda")))
    most, share = servo.problem.limits.velocity, 0.0
    for _ in range(40):
        lead(arm, servo, Twist(np.array((SPEED, 0.0, 0.1))), 0.1)
        share = max(share, float((np.abs(arm.state().velocities) / most).max()))
    held = lead(arm, servo, Twist(np.array((SPEED, 0.0, 0.1))), 0.1)[-1]
    back = float(lead(arm, servo, Twist(np.array((-SPEED, 0.0, -0.1))), 1.0)[-1, 0])
    words = f"joints at {share:.0%} of their limits at most, the tool at {np.linalg.norm(held):.3f} m/s "
    words += f"in the end; left at {-back:.3f} of {SPEED:g} m/s"
    return Outcome(words, share <= 1.0 and float(np.linalg.norm(held)) < 0.5 * SPEED and -back > 0.95 * SPEED)


def silence() -> Outcome:
    """22."""
    arm, servo = led(to.Scene(to.load("panda")))
    lead(arm, servo, Twist(np.array((0.0, SPEED, 0.0))), 0.6)
    quiet, share = arm.now(), 0.0
    while servo.moving and arm.now() < quiet + 2.0:
        servo.tick()
        arm.advance(TICK)
        _, velocities, accelerations = arm.committed(arm.now())
        limits = servo.problem.limits
        share = max(share, float((np.abs(velocities) / limits.velocity).max()))
        share = max(share, float((np.abs(accelerations) / limits.acceleration).max()))
    words = f"{servo.events[-1].words}; at rest {arm.now() - quiet:.2f} s after the last command, "
    rests = not arm.state().velocities.any()
    return Outcome(words + f"within {share:.0%} of the limits", rests and share <= 1.0 + 1e-6)


def in_contact() -> Outcome:
    """23."""
    scene = to.Scene(to.load("panda")).add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
    problem = to.Problem(scene=scene, group="panda_arm", start="ready", goal="ready")
    down = to.placement((0.5, 0.0, 0.007), rpy=(np.pi, 0.0, 0.0))
    free = replace(problem, scene=to.Scene(scene.robot), goal=to.frame_placement("panda_hand_tcp", down))
    pressed = to.plan(free).require().trajectory
    stuck = replace(problem, start=problem.reduced.all_positions(pressed(pressed.duration)))
    arm = IdealExecutor(scene.robot.joint_names, stuck.start_positions)
    arm.stop()
    supervisor = Supervisor(arm, stuck)
    home, judge, depths = supervisor.recover("ready"), Judge(stuck.reduced), list[float]()
    columns = [arm.joint_names.index(name) for name in stuck.reduced.joint_names]
    while supervisor.busy:
        found = judge.examine(arm.state().positions[columns]).collisions
        depths.append(min((pair.distance for pair in found), default=inf))
        supervisor.cycle()
        arm.advance(TICK)
    apart = int(np.argmax(np.isinf(depths)))
    monotone = bool((np.diff(depths[:apart]) >= -1e-6).all() and np.isinf(depths[apart:]).all())
    there = np.abs(arm.state().positions[columns] - problem.reduced.start_positions).max() < 1e-3
    words = f"from {-1e3 * depths[0]:.1f} mm deep, separated monotonically: {monotone}; at home: {there}"
    return Outcome(words, home and monotone and bool(there))
