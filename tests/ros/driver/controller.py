"""A joint trajectory controller as a client of our bridge: what ros2_control does with goals and stamps.

There is no ROS here, so this stands for `joint_trajectory_controller` and `joint_state_broadcaster`, by their
documentation: a goal of all joints begins at its stamp, replaces the goal under way, ends at rest, and is
joined by quintics; before its first point the joints hold. Positions are those that are commanded.
"""

import asyncio
import json
import threading
import time
from collections.abc import Callable, Coroutine, Generator, Mapping
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import numpy as np
from websockets.asyncio.client import connect

from tests.ros.rosbridge.bridged import Client, bridged
from trajopt.files.messages import Generation
from trajopt.files.moveit.trajectories import read_points
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.trajectory import Trajectory

JOINTS = ("shoulder", "elbow", "wrist")
BEGIN = (0.5, -1.0, 0.2)
NUMBERS = count(1)
KIND = "control_msgs/FollowJointTrajectory"
PERIOD = 0.01
CANCELED, REJECTED = {2: 5, 1: 2}, {2: 6, 1: 5}
SUCCEEDED = {2: 4, 1: 3}
"""Status numbers by version of ROS."""


class Controller:
    """Drives three joints that do exactly what they are told to.

    Attributes:
        action: Name of its action.
        states: Name of its topic of joint states.
        goals: The goals that have arrived, as documents.
        broken: A reason to give up the next goal; empty for none.
        stated: Members of its joint states that are different.
        silent: Whether it no longer publishes joint states.
    """

    def __init__(self, client: Client, version: int) -> None:
        number = next(NUMBERS)  # a bridge that serves several tests may not have forgotten the last one yet
        self.action, self.states = f"/arm{number}/follow_joint_trajectory", f"/arm{number}/joint_states"
        self.goals: list[Mapping[str, Any]] = []
        self.broken, self.silent = "", False
        self.stated: Callable[[dict[str, Any]], dict[str, Any]] = lambda message: message
        self._client, self._version = client, version
        self._motion: Trajectory | None = None
        self._begin, self._held, self._goal = 0.0, np.array(BEGIN), ""

    async def run(self) -> None:
        client = self._client
        if self._version == 2:
            await client.say(op="advertise_action", action=self.action, type=KIND.replace("/", "/action/"))
        else:
            await client.say(op="subscribe", topic=f"{self.action}/goal", type=f"{KIND}ActionGoal")
            await client.say(op="subscribe", topic=f"{self.action}/cancel", type="actionlib_msgs/GoalID")
            await client.say(op="advertise", topic=f"{self.action}/result", type=f"{KIND}ActionResult")
        await client.say(op="advertise", topic=self.states, type="sensor_msgs/JointState")
        await asyncio.gather(self._publish(), self._listen())

    def sample(self, now: float) -> tuple[Floats, Floats]:
        """Return the commanded positions and velocities at a time of the wall clock."""
        if self._motion is None or now < self._begin:
            return self._held, np.zeros(3)
        since = min(now - self._begin, self._motion.duration)
        order = [self._motion.joint_names.index(name) for name in JOINTS]
        return self._motion(since)[order], self._motion(since, 1)[order]

    async def _publish(self) -> None:
        while True:
            stamp = time.time_ns()
            positions, velocities = self.sample(1e-9 * stamp)
            names = ("sec", "nanosec") if self._version == 2 else ("secs", "nsecs")
            message = {
                "header": {"stamp": dict(zip(names, divmod(stamp, 10**9), strict=True))},
                "name": ["finger", *JOINTS],
                "position": [0.0, *positions.tolist()],
                "velocity": [0.0, *velocities.tolist()],
            }
            if not self.silent:
                await self._client.say(op="publish", topic=self.states, msg=self.stated(message))
            if self._goal and self._motion is not None and 1e-9 * stamp > self._begin + self._motion.duration:
                await self._end(SUCCEEDED)
            await asyncio.sleep(PERIOD)

    async def _listen(self) -> None:
        async for text in self._client.socket:
            message = json.loads(text)
            if message["op"] == "send_action_goal":
                await self._take(message["id"], message["args"])
            elif message["op"] == "cancel_action_goal" or message.get("topic") == f"{self.action}/cancel":
                await self._cancel(message["id"] if self._version == 2 else message["msg"]["id"])
            elif message.get("topic") == f"{self.action}/goal":
                await self._take(message["msg"]["goal_id"]["id"], message["msg"]["goal"])

    async def _take(self, goal_id: str, goal: Mapping[str, Any]) -> None:
        self.goals.append(goal)
        motion = read_points(Node(goal["trajectory"], "goal"))
        stamp = goal["trajectory"]["header"]["stamp"]
        begin = stamp.get("sec", stamp.get("secs")) + 1e-9 * stamp.get("nanosec", stamp.get("nsecs"))
        now = time.time()
        if set(motion.joint_names) != set(JOINTS) or begin + motion.duration < now or self.broken:
            await self._result(goal_id, REJECTED, self.broken or "the goal is rejected")
            return
        if self._goal:
            await self._end(CANCELED, "cancelled by a new goal")
        self._held, _ = self.sample(now)
        self._motion, self._begin, self._goal = motion, begin, goal_id

    async def _cancel(self, goal_id: str) -> None:
        if goal_id == self._goal:
            self._held, _ = self.sample(time.time())
            self._motion = None
            await self._end(CANCELED)

    async def _end(self, status: Mapping[int, int], reason: str = "") -> None:
        goal_id, self._goal = self._goal, ""
        await self._result(goal_id, status, reason)

    async def _result(self, goal_id: str, status: Mapping[int, int], reason: str) -> None:
        values, number = {"error_code": -1 if reason else 0, "error_string": reason}, status[self._version]
        if self._version == 2:
            told = {"id": goal_id, "action": self.action, "values": values, "status": number, "result": True}
            await self._client.say(op="action_result", **told)
        else:
            told = {
                "status": {"goal_id": {"id": goal_id}, "status": number, "text": reason},
                "result": values,
            }
            await self._client.say(op="publish", topic=f"{self.action}/result", msg=told)


@contextmanager
def in_a_thread(run: Callable[[threading.Event], Coroutine[Any, Any, None]]) -> Generator[None]:
    """Run a coroutine in a thread until the end of the block, when its event is set."""
    stop = threading.Event()
    thread = threading.Thread(target=lambda: asyncio.run(run(stop)))
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


@contextmanager
def bridge(folder: Path) -> Generator[str]:
    """Run a bridge; yield its address."""
    ports: SimpleQueue[int] = SimpleQueue()

    async def run(stop: threading.Event) -> None:
        async with bridged(folder) as listening:
            ports.put(listening.port)
            await asyncio.to_thread(stop.wait)

    with in_a_thread(run):
        yield f"ws://127.0.0.1:{ports.get(timeout=120.0)}"


@contextmanager
def controlled(url: str, generation: Generation = Generation.ROS2) -> Generator[Controller]:
    """Run a controller that is a client of a bridge."""
    version, made = (2 if generation is Generation.ROS2 else 1), SimpleQueue[Controller]()

    async def run(stop: threading.Event) -> None:
        async with connect(url) as socket:
            controller = Controller(Client(socket), version)
            running = asyncio.create_task(controller.run())
            made.put(controller)
            await asyncio.to_thread(stop.wait)
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    with in_a_thread(run):
        yield made.get(timeout=120.0)
