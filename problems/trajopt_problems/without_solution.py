"""Problems that have no solution, each for another reason: a planner must say which."""

from dataclasses import replace

import numpy as np

import trajopt as to

from .arms import panda, pointing, ur5

DOWN = (0.0, 0.0, -1.0)
UP = (0.0, 0.0, 1.0)


@to.suite.expected_status(to.Status.NO_INVERSE_KINEMATICS)
def out_of_reach() -> to.Problem:
    """Return the problem: a Panda reaches for a point that is farther away than its arm is long.

    What is hard: nothing but to admit it; the goal is a metre and a quarter from the base.

    Expected outcome: refused, no inverse kinematics.
    """
    arm = panda()
    return to.Problem(
        scene=to.Scene(arm.robot),
        group=arm.group,
        start=arm.ready,
        goal=pointing(arm, (1.25, 0.0, 0.4), DOWN),
        name="out of reach",
    )


@to.suite.expected_status(to.Status.CONFLICTING_CONSTRAINTS)
def down_and_up() -> to.Problem:
    """Return the problem: a Panda's hand must point down all the way and up at the end.

    What is hard: each of the two can be held, and only both together cannot.

    Expected outcome: refused, conflicting constraints.
    """
    arm = panda()
    return to.Problem(
        scene=to.Scene(arm.robot),
        group=arm.group,
        start=arm.ready,
        goal=pointing(arm, (0.4, 0.3, 0.5), UP),
        constraints=[to.axis_alignment(arm.tip, direction=DOWN, tolerance=0.3)],
        name="down and up",
    )


@to.suite.expected_status(to.Status.START_IN_COLLISION)
def start_in_collision() -> to.Problem:
    """Return the problem: a Panda's hand begins inside a box.

    What is hard: a solver that lets violations shrink would drag the hand out and call it a motion.

    Expected outcome: refused, start in collision.
    """
    arm = panda()
    return to.Problem(
        scene=to.Scene(arm.robot).add("box", to.Box(0.2, 0.2, 0.2), to.placement((0.307, 0.0, 0.5))),
        group=arm.group,
        start=arm.ready,
        goal=pointing(arm, (0.4, 0.4, 0.4), DOWN),
        name="start in collision",
    )


@to.suite.expected_status(to.Status.START_OUT_OF_LIMITS)
def start_beyond_limits() -> to.Problem:
    """Return the problem: a Panda begins with a joint beyond its limit.

    What is hard: clipping the start into the limits would be a jump.

    Expected outcome: refused, start out of limits.
    """
    arm = panda()
    return to.Problem(
        scene=to.Scene(arm.robot),
        group=arm.group,
        start={**arm.ready, "panda_joint4": 0.1},
        goal=pointing(arm, (0.4, 0.4, 0.4), DOWN),
        name="start beyond limits",
    )


@to.suite.expected_status(to.Status.START_BREAKS_CONSTRAINT)
def start_tilted() -> to.Problem:
    """Return the problem: what must stay upright all the way is tilted at the start.

    What is hard: the constraint holds everywhere but there.

    Expected outcome: refused, start breaks constraint.
    """
    arm = panda()
    return to.Problem(
        scene=to.Scene(arm.robot),
        group=arm.group,
        start={**arm.ready, "panda_joint6": arm.ready["panda_joint6"] + 0.5},
        goal=pointing(arm, (0.4, 0.4, 0.4), DOWN),
        constraints=[to.axis_alignment(arm.tip, direction=DOWN, tolerance=0.2)],
        name="start tilted",
    )


@to.suite.expected_status(to.Status.GOAL_IN_COLLISION)
def goal_in_collision() -> to.Problem:
    """Return the problem: a UR5 reaches for a point in the middle of a block.

    What is hard: many configurations reach the point, and all of them must be seen to collide.

    Expected outcome: refused, goal in collision.
    """
    arm = ur5()
    return to.Problem(
        scene=to.Scene(arm.robot).add("block", to.Box(0.3, 0.3, 0.4), to.placement((0.5, 0.3, 0.2))),
        group=arm.group,
        start=arm.ready,
        goal=pointing(arm, (0.5, 0.3, 0.25), DOWN),
        name="goal in collision",
    )


@to.suite.expected_status(to.Status.GOAL_OUT_OF_LIMITS)
def goal_beyond_limits() -> to.Problem:
    """Return the problem: a Panda's elbow must stretch beyond its limit.

    What is hard: nothing lies in the way, only the joint's own limit.

    Expected outcome: refused, goal out of limits.
    """
    arm = panda()
    joints = {name: value for name, value in arm.ready.items() if "finger" not in name}
    return to.Problem(
        scene=to.Scene(arm.robot),
        group=arm.group,
        start=arm.ready,
        goal=to.joint_positions({**joints, "panda_joint4": 0.2}),
        name="goal beyond limits",
    )


@to.suite.expected_status(to.Status.GOAL_BREAKS_CONSTRAINT)
def goal_tilted() -> to.Problem:
    """Return the problem: the joints at the goal tilt what must stay upright all the way.

    What is hard: goal and path constraint are asked in different coordinates.

    Expected outcome: refused, goal breaks constraint.
    """
    arm = panda()
    joints = {name: value for name, value in arm.ready.items() if "finger" not in name}
    return to.Problem(
        scene=to.Scene(arm.robot),
        group=arm.group,
        start=arm.ready,
        goal=to.joint_positions({**joints, "panda_joint1": 0.8, "panda_joint6": 2.2}),
        constraints=[to.axis_alignment(arm.tip, direction=DOWN, tolerance=0.2)],
        name="goal tilted",
    )


@to.suite.expected_status(to.Status.PROVEN_INFEASIBLE)
def walled_in() -> to.Problem:
    """Return the problem: a UR5 between walls that begin at its base must reach the other side.

    What is hard: start and goal are both clear, and only every way between them is blocked: the upper
    arm stands off the shoulder's axis and would sweep through a wall. An optimiser cannot prove
    that; it must end without claiming success, and the proof is another's.

    Expected outcome: refused, walled in.
    """
    arm = ur5()
    walls = [(to.Box(1.4, 0.02, 3.0), to.placement((side * (0.11 + 0.7), 0.0, 0.0))) for side in (-1.0, 1.0)]
    scene = to.Scene(arm.robot).add("walls", walls, to.placement(rpy=(0.0, 0.0, -np.pi / 4)))
    start = {**arm.ready, "shoulder_lift_joint": -0.9, "elbow_joint": 1.2}
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=start,
        goal=to.joint_positions({**start, "shoulder_pan_joint": start["shoulder_pan_joint"] + np.pi}),
        name="walled in",
    )


@to.suite.expected_status(to.Status.GOAL_CANNOT_BE_HELD)
def motors_too_weak() -> to.Problem:
    """Return the problem: a UR5 with a fifth of its torque must hold its arm stretched out.

    What is hard: the path is free and every joint within its limits; only gravity speaks against it.

    Expected outcome: refused, the goal cannot be held.
    """
    arm = ur5()
    weak = replace(arm.robot, limits=replace(arm.robot.limits, effort=0.2 * arm.robot.limits.effort))
    stretched = dict(zip(arm.ready, (0.6, -0.2, 0.2, -1.5, -1.571, 0.0), strict=True))
    return to.Problem(
        scene=to.Scene(weak),
        group=arm.group,
        start=dict(zip(arm.ready, (0.0, -1.571, 0.0, -1.571, -1.571, 0.0), strict=True)),
        goal=to.joint_positions(stretched),
        name="motors too weak",
    )
