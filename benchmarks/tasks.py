"""Whole tasks: the order of many holes, and a tray of parts, beside motions planned one by one.

python -m benchmarks.tasks [--holes 245] [--parts 20] [--page FILE]
"""

import argparse
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import TypeAlias

import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from trajopt.robot.joints import JointLimits
from trajopt.tasks import AnyOrder, Dwell, MoveTo, PickObject, PlaceObject, Task, TaskResult, TaskStage
from trajopt.tasks.grasping import Grasp, Place, grasps_of, gripper_of, pick_and_place
from trajopt.tasks.grasping.simulation import Hold
from trajopt.tasks.tour import Tours
from trajopt.timing.time_scaling import travel_time
from trajopt.values.arrays import Floats, Ints

State: TypeAlias = str | Mapping[str, float]
UR5E = Path(str(files("compas_robots"))) / "data" / "ur_description" / "urdf" / "ur5e.urdf"
UPRIGHT = {
    "shoulder_pan_joint": 0.0, "shoulder_lift_joint": -np.pi / 2, "elbow_joint": 0.0,
    "wrist_1_joint": -np.pi / 2, "wrist_2_joint": 0.0, "wrist_3_joint": 0.0,
}  # fmt: skip
REST = 1e-3
"""Rest at each hole [s]."""
POSTURES = 12
"""Postures of each hole for the two simple rules, as many as `AnyOrder` takes."""


@dataclass(frozen=True)
class Measured:
    """A row of a table: a rule, its cycle time [s] and the process time of planning [s]."""

    rule: str
    cycle: float
    cpu: float

    def cells(self, ours: float) -> tuple[str, ...]:
        """Return the cells, with the ratio of our cycle time to this one."""
        return self.rule, f"{self.cycle:.1f}", f"{ours / self.cycle:.2f}", f"{self.cpu:.1f}"


@dataclass(frozen=True, eq=False)
class Plate:
    """Holes in a plate before a robot; the tool may turn about its axis.

    Attributes:
        scene: The robot and the plate.
        group: Planning group.
        home: State before and after.
        points: Of the tool at each hole, shape (k, 3) [m].
        goals: Placement of the tool at each.
    """

    scene: to.Scene
    group: str
    home: State
    points: Floats
    goals: tuple[to.Requirement, ...]

    @staticmethod
    def of(name: str, group: str, home: State, tool: str, count: int) -> "Plate":
        """Draw holes, the same for each robot."""
        where = to.placement((0.5, 0.0, 0.3))
        scene = to.Scene(to.load(name)).add("plate", to.Box(0.4, 0.5, 0.02), where)
        points = np.random.default_rng(1).uniform((0.33, -0.22), (0.67, 0.22), (count, 2))
        points = np.column_stack((points, np.full(count, 0.35)))
        goals = tuple(
            to.frame_placement(
                tool, to.placement(point, rpy=(np.pi, 0.0, 0.0)), rotation_tolerance=(1e-3, 1e-3, np.inf)
            )
            for point in points
        )
        return Plate(scene, group, home, points, goals)

    def measured(self, rule: str, stages: Sequence[TaskStage], *, improve: bool = False) -> Measured:
        """Plan stages and the way home."""
        begin = time.process_time()
        task = Task(scene=self.scene, group=self.group, start=self.home, stages=[*stages, MoveTo(self.home)])
        result = to.plan(task, improve=improve)
        return Measured(rule, result.duration, time.process_time() - begin)

    def ours(self, rest: float) -> Measured:
        """Plan the order and the postures together."""
        items = [[MoveTo(goal), *([Dwell(rest)] if rest else [])] for goal in self.goals]
        rule = "order and postures together" + ("" if rest else ", in passing")
        return self.measured(rule, [AnyOrder(items, then=self.home)], improve=not rest)

    def tours(self) -> tuple[Tours, Floats, list[str]]:
        """Return the postures of all holes and the times between them."""
        problems = [
            to.Problem(scene=self.scene, group=self.group, start=self.home, goal=goal) for goal in self.goals
        ]
        found = [to.goal_configurations(problem)[:POSTURES] for problem in problems]
        postures = np.array([row for rows in found for row in rows])
        groups = np.repeat(np.arange(len(found)), [len(rows) for rows in found])
        reduced = problems[0].reduced
        limits: JointLimits = reduced.limits
        home = travel_time(postures, reduced.start_positions, limits, rests=True)
        between = travel_time(postures[:, None], postures[None], limits, rests=True)
        return Tours(groups, home, between, home), postures, list(reduced.joint_names)

    def single_plans(self) -> Measured:
        """Go to the hole in space that is nearest to the tool, each by a plan of its own."""
        begin, at, cycle = time.process_time(), self.scene.robot.positions(self.home), 0.0
        left = list(range(len(self.goals)))
        while left:
            tool = self.scene.placement_of(self._tool, at).translation
            hole = min(left, key=lambda each: float(np.linalg.norm(self.points[each] - tool)))
            left.remove(hole)
            problem = to.Problem(scene=self.scene, group=self.group, start=at, goal=self.goals[hole])
            plan = to.plan(problem).require()
            cycle += plan.trajectory.duration + REST
            at = problem.reduced.all_positions(plan.trajectory(plan.trajectory.duration))
        home = to.plan(to.Problem(scene=self.scene, group=self.group, start=at, goal=self.home)).require()
        cpu = time.process_time() - begin
        return Measured("nearest hole, single plans", cycle + home.trajectory.duration, cpu)

    def nearest_neighbour(self) -> Measured:
        """Go to the nearest posture of any hole that is left."""
        begin = time.process_time()
        tours, postures, joints = self.tours()
        tour = tours.nearest_neighbour()
        return self._driven("nearest posture, one task", tour, postures, joints, begin, REST)

    def robo_tsp(self, rest: float) -> Measured:
        """Order in space, then postures by the shortest path (Suárez-Ruiz, Lembono and Pham, ICRA 2018)."""
        begin = time.process_time()
        tours, postures, joints = self.tours()
        flat = np.linalg.norm(self.points[:, None] - self.points[None], axis=-1)
        tool = self.scene.placement_of(self._tool, self.scene.robot.positions(self.home)).translation
        ends = np.linalg.norm(self.points - tool, axis=1)
        holes = Tours(np.arange(len(flat)), ends, flat, ends).shortest(np.random.default_rng(0))
        first = np.array([int(np.flatnonzero(tours.groups == hole)[0]) for hole in holes])
        rule = "RoboTSP's rule" + ("" if rest else ", in passing")
        return self._driven(rule, tours.chosen(first), postures, joints, begin, rest)

    @property
    def _tool(self) -> str:
        return self.goals[0].frames[0]

    def _driven(
        self, rule: str, tour: Ints, postures: Floats, joints: list[str], begin: float, rest: float
    ) -> Measured:
        searched = time.process_time() - begin
        stages = [
            stage
            for node in tour.tolist()
            for stage in (
                MoveTo(dict(zip(joints, postures[node].tolist(), strict=True))),
                *([Dwell(rest)] if rest else []),
            )
        ]
        found = self.measured(rule, stages, improve=not rest)
        return replace(found, cpu=found.cpu + searched)


def plates(count: int) -> str:
    """Return the table of holes."""
    rows: list[tuple[str, ...]] = []
    for robot in (
        ("panda", "panda_arm", "ready", "panda_hand_tcp"),
        ("ur5", "manipulator", "up", "tool0"),
        (str(UR5E), "all", UPRIGHT, "tool0"),
    ):
        plate = Plate.of(*robot, count)
        ours = plate.ours(0.0)
        simple = plate.single_plans(), plate.nearest_neighbour(), plate.robo_tsp(REST), plate.robo_tsp(0.0)
        for row in (*simple, plate.ours(REST), ours):
            rows.append((Path(robot[0]).stem, *row.cells(ours.cycle)))
            print(*rows[-1], sep=" | ", flush=True)
    return table(("robot", "rule", "cycle time [s]", "last / this", "CPU [s]"), rows)


@dataclass(frozen=True, eq=False)
class Tray:
    """Parts on a table, and the cells of a tray that they go to."""

    scene: to.Scene
    parts: tuple[str, ...]

    @staticmethod
    def of(count: int) -> "Tray":
        """Place the parts in rows of four."""
        scene = to.Scene(to.load("panda")).add(
            "table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02))
        )
        parts = tuple(f"part {number}" for number in range(count))
        for number, part in enumerate(parts):
            scene = scene.add(part, to.Box(0.04, 0.04, 0.06), cell(number, -0.45), mass=0.1)
        return Tray(scene, parts)

    def grasps(self, part: str) -> tuple[Grasp, ...]:
        """Return the grasps of a part."""
        return grasps_of(self.scene, part, gripper_of(self.scene.robot))

    def place(self, number: int) -> Place:
        """Return the place of a part."""
        return Place(placement=cell(number, 0.12))

    def singly(self) -> Measured:
        """Pick and place the parts one by one."""
        begin, scene, at, cycle = time.process_time(), self.scene, "ready", 0.0
        for number, part in enumerate(self.parts):
            done = pick_and_place(
                scene, part, group="panda_arm", start=at, grasps=self.grasps(part), places=self.place(number)
            )
            cycle += done.timeline.duration
            scene, at = done.final_scene, done  # pyright: ignore[reportAssignmentType]
        home = to.plan(to.Problem(scene=scene, group="panda_arm", start=at, goal="ready")).require()
        return Measured(
            "`pick_and_place`, one by one", cycle + home.trajectory.duration, time.process_time() - begin
        )

    def planned(self, *, blend: float, improve: bool) -> tuple[Measured, TaskResult]:
        """Plan one task."""
        begin = time.process_time()
        stages = [
            stage
            for number, part in enumerate(self.parts)
            for stage in (PickObject(part, self.grasps(part)), PlaceObject(part, self.place(number)))
        ]
        task = Task(
            scene=self.scene, group="panda_arm", start="ready", stages=[*stages, MoveTo("ready")], blend=blend
        )
        result = to.plan(task, improve=improve)
        rule = f"`Task`, blend {1e3 * blend:.0f} mm{', improved' if improve else ''}"
        return Measured(rule, result.duration, time.process_time() - begin), result


def cell(number: int, y: float) -> to.Placement:
    """Return the placement of a part in rows of four."""
    return to.placement((0.34 + 0.08 * (number % 4), y + 0.08 * (number // 4), 0.03))


def trays(count: int) -> str:
    """Return the table of trays, and a sentence about the simulation."""
    tray = Tray.of(count)
    singly = tray.singly()
    found = [
        tray.planned(blend=blend, improve=improve)
        for blend, improve in ((0.0, False), (0.05, False), (0.05, True))
    ]
    rows = [
        (row.rule, f"{row.cycle:.1f}", f"{row.cycle / singly.cycle:.2f}", f"{row.cpu:.1f}")
        for row in (singly, *(row for row, _ in found))
    ]
    for row in rows:
        print(*row, sep=" | ", flush=True)
    result = found[-1][1]
    rolled = to.simulate(result)
    held = sum(one.hold is Hold.HELD for one in rolled.handlings)
    worst = max(one.final_error.position if one.final_error else np.inf for one in rolled.handlings)
    words = (
        f"In one run of MuJoCo friction alone carried {held} of {count} parts of the last row to within "
        f"{1e3 * worst:.2f} mm of their places."
    )
    return table(("rule", "cycle time [s]", "ratio", "CPU [s]"), rows) + f"\n\n{words}"


def main() -> None:
    """Measure, print, and write the section of the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--holes", type=int, default=245)
    parser.add_argument("--parts", type=int, default=20)
    parser.add_argument("--page", type=Path, help="write the tables into this page")
    given = parser.parse_args()
    written = "\n\n".join((plates(given.holes), trays(given.parts)))
    print(written)
    if given.page is not None:
        write_section(given.page, "tasks", written)


if __name__ == "__main__":
    main()
