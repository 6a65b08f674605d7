"""An arm among what moves, appears and expires: it waits, hurries, goes around, or comes in phase."""

from dataclasses import replace

import numpy as np

import trajopt as to

from .arms import Arm, panda, pointing, ur5, xarm7

DOWN = (0.0, 0.0, -1.0)
TABLE = to.Box(1.4, 1.8, 0.04), to.placement((0.5, 0.0, -0.06))


def crossing_panda() -> to.Problem:
    """Return the problem: a crate flies straight through the room that a Panda's hand swings through.

    What is hard: the fastest motion is hit half way; a detour around everywhere that the crate will be costs
    more than to let it pass.

    Expected outcome: solved.
    """
    arm = panda()
    flies = to.Track.through((0.0, 1.8), [to.placement((x, 0.25, 0.4)) for x in (1.4, -1.0)])
    known = to.Prediction(flies, (0.01, 0.01, 0.0), until=6.0)
    return _swing(arm, _around(arm).add("crate", to.Box(0.12, 0.12, 0.9), motion=known), "crossing")


def late_crate_ur5() -> to.Problem:
    """Return the problem: a slow crate is about to block the way of a UR5, which can be past it in time.

    What is hard: where the crate ends it stands in the way for good, so that whoever waits, or plans around
    where it has been and will be, takes longer than who goes at once.

    Expected outcome: solved.
    """
    arm = ur5()
    creeps = to.Track.through((0.0, 8.0), [to.placement((x, 0.0, 0.4)) for x in (1.3, 0.4)])
    return _swing(arm, _around(arm).add("crate", to.Box(0.12, 0.12, 0.8), motion=creeps), "late crate")


def parked_crate_xarm7() -> to.Problem:
    """Return the problem: a crate is set down where an xArm7's hand would pass, and stays.

    What is hard: no timing of the shortest path will do, however long it waits; it takes another shape.

    Expected outcome: solved.
    """
    arm = xarm7()
    lands = to.Track.through((0.0, 0.4), [to.placement((0.5, 0.0, z)) for z in (1.2, 0.25)])
    return _swing(arm, _around(arm).add("crate", to.Box(0.12, 0.12, 0.5), motion=lands), "parked crate")


def revolving_door() -> to.Problem:
    """Return the problem: an arm of two joints goes through where a door with two wings turns.

    What is hard: the door never stops, and there is a way for the arm only between one wing and the next.

    Expected outcome: solved.
    """
    robot = to.load("planar2")
    turns = to.Track.constant_velocity(
        to.placement((0.75, 0.0, 0.12)), (0.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 1.2), end=60.0
    )
    return to.Problem(
        scene=to.Scene(robot).add("door", to.Box(0.5, 0.02, 0.2), motion=turns),
        start={"joint1": -1.1, "joint2": 0.3},
        goal=to.joint_positions({"joint1": 0.9, "joint2": 0.4}),
        name="revolving door",
    )


def lid_lifted_ur5() -> to.Problem:
    """Return the problem: a UR5 reaches into a box whose lid is taken off after two seconds.

    What is hard: the goal is free, and any motion that does not know the time either hits the lid or begins
    only once it is gone.

    Expected outcome: solved.
    """
    arm = ur5()
    sides = [
        (to.Box(0.02 if x else 0.4, 0.4 if x else 0.02, 0.15), to.placement((x * 0.2, y * 0.2, 0.0)))
        for x, y in ((-1, 0), (1, 0), (0, -1), (0, 1))
    ]
    scene = (
        _around(arm)
        .add("box", sides, to.placement((0.55, 0.1, 0.035)))
        .add("lid", to.Box(0.42, 0.42, 0.01), to.placement((0.55, 0.1, 0.12)), expires=2.0)
    )
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.ready,
        goal=pointing(arm, (0.55, 0.1, 0.06), DOWN),
        name="lid lifted",
    )


def beside_another_arm() -> to.Problem:
    """Return the problem: a Panda shares its room with another, which moves as it has been told to.

    What is hard: the other arm gives way to nobody; its hand comes through the room that this one has to
    cross, and whoever waits until it is done takes twice as long.

    Expected outcome: solved.
    """
    arm = panda()
    joints = [f"panda_joint{number}" for number in range(1, 8)]
    held, reached = ({**arm.ready, "panda_joint1": turn, "panda_joint2": 0.2} for turn in (-0.9, 0.9))
    points = np.array([[each[joint] for joint in joints] for each in (held, reached)])
    still = np.zeros_like(points)
    moves = to.Trajectory(tuple(joints), np.array((0.0, 2.0)), points, still, still)
    goal = to.joint_positions({joint: reached[joint] for joint in joints})
    other = to.Problem(scene=to.Scene(arm.robot), group=arm.group, start=held, goal=goal).reduced
    facing = to.placement((1.05, 0.0, 0.0), rpy=(0.0, 0.0, np.pi))
    return _swing(
        arm, _around(arm).with_robot_in_motion("other", other, moves, base=facing), "beside another arm"
    )


def conveyor_ur5() -> to.Problem:
    """Return the problem: a UR5's tool meets a part on a conveyor and goes along with it for half a second.

    What is hard: where the goal is depends on when the arm gets there, and at the end the arm has to be at
    rest as seen from the part, not from the floor.

    Expected outcome: solved.
    """
    arm = ur5()
    carried = to.Track.constant_velocity(to.placement((0.5, -0.6, 0.045)), (0.0, 0.2, 0.0), end=10.0)
    scene = (
        _around(arm)
        .add("belt", to.Box(0.2, 1.8, 0.02), to.placement((0.5, 0.0, 0.01)))
        .add("part", to.Box(0.05, 0.05, 0.05), motion=carried)
    )
    above = to.placement((0.0, 0.0, 0.1), rpy=(np.pi, 0.0, 0.0))
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=arm.ready,
        goal=to.frame_placement(arm.tip, above, reference="part"),
        dwell=0.5,
        name="conveyor",
    )


@to.suite.expected_status(to.Status.INEVITABLE)
def swept_start_panda() -> to.Problem:
    """Return the problem: a wall sweeps the whole room of a Panda, faster than the arm can leave.

    What is hard: there is no motion to look for, and a planner that looks for one anyway never ends.

    Expected outcome: refused, inevitable.
    """
    arm = panda()
    sweeps = to.Track.through((0.0, 0.4), [to.placement((x, 0.0, 1.25)) for x in (2.0, -2.0)])
    return _swing(arm, _around(arm).add("wall", to.Box(0.05, 4.0, 2.0), motion=sweeps), "swept start")


@to.suite.expected_status(to.Status.GOAL_OCCUPIED)
def occupied_goal_ur5() -> to.Problem:
    """Return the problem: a ball circles where a UR5's tool is to be, and never leaves.

    What is hard: every place on the ball's way is free again and again, and the goal is so at no time.

    Expected outcome: refused, goal occupied.
    """
    arm = ur5()
    times: np.ndarray = np.linspace(0.0, 60.0, 121)
    places = [to.placement((0.4 + 0.05 * np.cos(t), 0.45 + 0.05 * np.sin(t), 0.25)) for t in 2.0 * times]
    circles = to.Track.through(times, places)
    return _swing(arm, _around(arm).add("ball", to.Sphere(0.15), motion=circles), "occupied goal")


@to.suite.expected_status(to.Status.INEVITABLE)
def closing_walls_xarm7() -> to.Problem:
    """Return the problem: two walls close the room of an xArm7 from both sides, faster than its joints turn.

    What is hard: for a tenth of a second everything is free, and the arm is on its way in vain.

    Expected outcome: refused, inevitable.
    """
    arm, scene = xarm7(), to.Scene(xarm7().robot)
    for name, side in (("left wall", 1.0), ("right wall", -1.0)):
        ends = [to.placement((0.0, side * away, 1.25)) for away in (2.0, 0.05)]
        scene = scene.add(name, to.Box(4.0, 0.05, 2.0), motion=to.Track.through((0.0, 0.3), ends))
    return _swing(arm, scene, "closing walls")


@to.suite.expected_status(to.Status.GOAL_OCCUPIED)
def goal_free_for_a_moment() -> to.Problem:
    """Return the problem: an arm of two joints is to stay for a second where it is free for a third of one.

    What is hard: there is a motion that is clear all the way to its end, and it is of no use.

    Expected outcome: refused, goal occupied.
    """
    robot, post = to.load("planar2"), to.Cylinder(0.05, 0.4)
    there = to.placement(
        (0.4 * np.cos(0.9) + 0.35 * np.cos(1.3), 0.4 * np.sin(0.9) + 0.35 * np.sin(1.3), 0.15)
    )
    scene = to.Scene(robot).add("first", post, there, expires=2.0).add("second", post, there, appears=2.3)
    return to.Problem(
        scene=scene,
        start={"joint1": -1.1, "joint2": 0.3},
        goal=to.joint_positions({"joint1": 0.9, "joint2": 0.4}),
        dwell=1.0,
        name="goal free for a moment",
    )


@to.suite.expected_status(to.Status.TOO_LATE)
def too_late_xarm7() -> to.Problem:
    """Return the problem: an xArm7 is to be at its goal before a press closes, too soon for its joints.

    What is hard: the way is free until then, and only the limits of the joints say that it is too long.

    Expected outcome: refused, too late.
    """
    arm = xarm7()
    closes = to.Track.through((0.2, 0.4), [to.placement((0.35, 0.36, z)) for z in (1.0, 0.45)])
    scene = _around(arm).add("press", to.Box(0.3, 0.3, 0.05), motion=closes)
    return replace(_swing(arm, scene, "too late"), finish_by=0.3)


def _around(arm: Arm) -> to.Scene:
    return to.Scene(arm.robot).add("table", *TABLE)


def _swing(arm: Arm, scene: to.Scene, name: str) -> to.Problem:
    """Ask for a swing from the right to the left, the tool pointing down all the time at both ends."""

    def side(turn: float) -> tuple[to.Requirement, to.Requirement]:
        return pointing(arm, (arm.reach * np.cos(turn), arm.reach * np.sin(turn), 0.25), DOWN)

    start = arm.at(_around(arm), *side(-0.8))
    goal = arm.at(_around(arm), *side(0.8))
    moved = {joint: goal[joint] for joint in scene.robot.group(arm.group).joints}
    return to.Problem(
        scene=scene,
        group=arm.group,
        start=start,
        goal=to.joint_positions(moved),
        velocity_scaling=0.5,
        acceleration_scaling=0.5,
        name=name,
    )
