"""A pilot that keeps MoveIt's rule: the waypoints of the remaining path are checked, nothing between them.

What `plan_execution` does (moveit_ros/planning/plan_execution/src/plan_execution.cpp): the whole motion is
given to the controller. 100 times a second, if the scene was updated, each waypoint of the motion from the
current one on is checked for collision (`isRemainingPathValid`); where one collides, the execution is
cancelled, and when the robot stands a motion is planned from there. There are five attempts. Waypoints are
0.1 s apart, as its time parameterisation leaves them.

Where this is kinder than what was read: the controller that is cancelled brakes as hard as the limits of
acceleration and jerk allow (today's holds the position of that moment, and has been able to decelerate since
2026); and motions are planned by the same planner as the supervisor's, so that the rule alone makes the
difference.
"""

import time
from math import ceil, inf

import numpy as np

import trajopt as to
from trajopt.driving import Event, EventKind, Executor, SupervisorOptions
from trajopt.driving.committed_motion import CommittedMotion
from trajopt.driving.motion_guard import start_from
from trajopt.optimise.methods.timing import stopping_motion
from trajopt.planning import on_the_way
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.verify import Judge

PERIOD = 0.01
"""Time between two looks [s]."""
WAYPOINTS = 0.1
"""Time between two waypoints [s]: `resample_dt` of its time parameterisation."""
ATTEMPTS = 5
"""So often a motion is planned at most (`default_max_replan_attempts`)."""
LEAD = 0.02
"""A motion from rest begins so much later than it is known [s]; planning takes no simulated time."""


class WaypointPilot:
    """Drives a whole motion, and checks the waypoints that are left when the scene changes."""

    def __init__(self, executor: Executor, problem: to.Problem, options: SupervisorOptions) -> None:
        """Take the robot as it stands."""
        self.events: list[Event] = []
        self.seconds: dict[str, list[float]] = {}
        self._executor, self._problem, self._scene, self._options = executor, problem, problem.scene, options
        self._committed = CommittedMotion(executor.joint_names, executor.state().commanded)
        self._begin, self._motion = inf, None
        self._left, self._changed, self._given_up = ATTEMPTS, False, False

    @property
    def busy(self) -> bool:
        """Whether there is a goal that is not reached."""
        return not self._given_up or self._executor.now() < self._committed.end

    @property
    def blocked(self) -> bool:
        """Whether all attempts are used up, and the robot stands."""
        return not self.busy

    def go(self, problem: to.Problem) -> None:
        """Ask for a goal."""
        self._problem = problem

    def see(self, scene: Scene, stamp: float | None = None) -> None:
        """Set the known world."""
        self._scene, self._changed = scene, True
        self._stamp = self._executor.now() if stamp is None else stamp

    def cycle(self) -> None:
        """Check the remaining waypoints, or plan."""
        now = self._executor.now()
        if self._executor.fault():
            self._given_up = True
            return
        if now < self._committed.end:
            if self._motion is not None and (self._changed or self._scene.changing):
                self._look(now)
            return
        if self._motion is not None:
            self._note(EventKind.REACHED)
            self._given_up = True
        elif not self._given_up:
            self._plan(now)

    def _look(self, now: float) -> None:
        """Check the waypoints that are left; brake where one collides."""
        begun, self._changed = time.process_time(), False
        motion = self._motion
        assert motion is not None  # it is on its way
        judge = Judge(reduce_model(self._now(now), self._problem.group, self._problem.start_positions))
        first = max(ceil((now - self._begin) / WAYPOINTS) - 1, 0)
        moments = np.append(np.arange(first * WAYPOINTS, motion.duration, WAYPOINTS), motion.duration)
        clear = all(judge.examine(motion(moment)).clear for moment in moments)
        self._spent("check", begun)
        if not clear:
            self._brake(now)

    def _brake(self, now: float) -> None:
        begin = now + self._executor.latency
        ahead = self._committed.ahead(begin, self._problem.reduced.joint_names)
        self._motion = None
        if ahead is None:
            return
        here = self._standing(begin)
        stop = stopping_motion(on_the_way(here, ahead, 0.0))
        self._splice(stop, begin)
        self._note(EventKind.STOPPING, f"at rest in {1e3 * stop.duration:.0f} ms")

    def _plan(self, now: float) -> None:
        begun, at = time.process_time(), now + LEAD
        if self._left == 0:
            self._given_up = True
            return
        self._left -= 1
        result = to.plan(self._standing(at), budget=self._options.budget)
        self._spent("plan", begun)
        if not result.verified:
            self._note(EventKind.NO_PLAN, result.reason)
            return
        self._begin, self._motion = at, result.require().trajectory
        self._splice(self._motion, at)
        self._note(EventKind.STARTED)

    def _standing(self, at: float) -> to.Problem:
        problem, driven, robot = self._problem, self._executor.joint_names, self._scene.robot
        positions = np.array(problem.start_positions)
        positions[robot.index(driven)] = self._committed(at)[0]
        return start_from(problem, robot.followed(positions), self._now(at))

    def _now(self, time: float) -> Scene:
        """Return the scene as it is at a time: for MoveIt all things stay where they are."""
        scene = self._scene
        if scene.changing:
            scene = scene.at(max(time - self._stamp, 0.0))
            for name in scene.changing:
                scene = scene.with_motion(name)
        return scene

    def _splice(self, motion: to.Trajectory, at: float) -> None:
        refused = self._executor.splice(motion, at)
        if refused:
            self._note(EventKind.REJECTED, refused)
            return
        self._committed.splice(motion, at, now=self._executor.now())

    def _note(self, kind: EventKind, words: str = "") -> None:
        self.events.append(Event(self._executor.now(), kind, words))

    def _spent(self, stage: str, begun: float) -> None:
        self.seconds.setdefault(stage, []).append(time.process_time() - begun)
