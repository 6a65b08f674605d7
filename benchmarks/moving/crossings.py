"""MotionBenchMaker's Panda and UR5 with one box that crosses the still motion: the generator, frozen.

python -m benchmarks.moving.crossings DATA --every 1 --out benchmarks/moving/crossings.jsonl

The boxes were drawn once and lie in `crossings.jsonl`, so that they stay the same when the still motions
change. Rules, published before anything was tuned to them:

* The problems are all of the Panda's and the UR5's, 350 each, less those whose still problem has no
  verified motion. The still motion q(t), 0 <= t <= T, is that of `plan()` with default options at commit
  864fd34.
* Random numbers: `default_rng((SEED, row of the robot, crc32 of the set's name, number of the problem))`,
  in the order of the next points.
* A moment, evenly in [0, T]. Of the arm's and hand's bodies those whose middle (of the bounding box)
  travels 0.1 m at least along the still motion; if none does, the one that travels farthest. A joint,
  evenly among those that carry them, for a gripper has many; a body of it, evenly. The middle of this body
  at this moment is where the middle of the box is at this moment.
* The box: three sides, each evenly in 5 to 15 cm; an orientation, evenly of all, that it keeps; a
  direction, evenly of all; a speed, evenly in 0.1 to 1 m/s. It goes straight at this speed from 3 m before
  that place to 3 m behind it, where it rests: outside the arm's reach both times. Its way through what
  stands in the scene is not looked at.
* All is drawn again, at most 100 times, while the box at this moment does not touch the arm, or is nearer
  than 10 mm to the arm at the start at time 0, where no motion could begin. It may sweep the start later,
  and the goal at any time: some problems have no solution.
"""

import argparse
import json
import zlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin

import trajopt as to
from trajopt.geometry.geometry import collision_geometry
from trajopt.lab.suite import Instance
from trajopt.lab.suite.instance import find_instances
from trajopt.scene.reduced import ReducedModel
from trajopt.values.placement import Placement
from trajopt.values.shapes.shapes import bounding_box

SEED = 20261122
ROBOTS = ("panda", "ur5")
FILE = Path(__file__).with_name("crossings.jsonl")
BOX = "crossing"
"""Name of the box in the scene."""
TRAVEL, AWAY, CLEAR = 0.1, 3.0, 0.010
"""Of the middle of a body that is hit; of the box to that place and on; of box and arm at time 0 [m]."""
SIDES, SPEEDS = (0.05, 0.15), (0.1, 1.0)
DRAWS = 100


@dataclass(frozen=True)
class Crossing:
    """A box on its way.

    Attributes:
        key: Robot, set and number of the problem: "panda/box/7".
        sides: Of the box [m].
        orientation: Quaternion (x, y, z, w).
        place: Of its middle at `moment` [m].
        velocity: Of the box [m/s].
        moment: When it hits the still motion [s].
        still: Duration of the still motion that it was drawn for [s].
        body: The link that it hits.
    """

    key: str
    sides: tuple[float, ...]
    orientation: tuple[float, ...]
    place: tuple[float, ...]
    velocity: tuple[float, ...]
    moment: float
    still: float
    body: str

    @property
    def shape(self) -> to.Box:
        """The box."""
        return to.Box(*self.sides)

    @property
    def track(self) -> to.Track:
        """Its way."""
        half = AWAY / float(np.linalg.norm(self.velocity))
        begin = self.placement(self.moment - half)
        return to.Track.constant_velocity(
            begin, self.velocity, start=self.moment - half, end=self.moment + half
        )

    def placement(self, time: float) -> Placement:
        """Return where it is at a time on its way."""
        xyz = np.array(self.place) + np.array(self.velocity) * (time - self.moment)
        return to.placement(xyz, quaternion=self.orientation)

    def add_to(self, problem: to.Problem) -> to.Problem:
        """Return the problem with the box."""
        return replace(problem, scene=problem.scene.add(BOX, self.shape, motion=self.track))


class Arm:
    """The bodies that a group's joints carry, or those that none does, and their distances from one more."""

    def __init__(self, reduced: ReducedModel, *, carried: bool = True) -> None:
        """Take the links' bodies that move, or those that stand still."""
        self._reduced, self._data = reduced, reduced.model.createData()
        links = reduced.scene.robot.links
        self.bodies = [body for body in reduced.bodies if bool(body.joint) is carried and body.owner in links]

    def placements(self, positions: np.ndarray) -> list[Placement]:
        """Return where the bodies are, for positions (n,)."""
        pin.forwardKinematics(self._reduced.model, self._data, self._reduced.configuration(positions))
        at = [self._data.oMi[body.joint] for body in self.bodies]
        return [
            Placement(where.rotation, where.translation) * body.placement
            for where, body in zip(at, self.bodies, strict=True)
        ]

    def middles(self, positions: np.ndarray) -> np.ndarray:
        """Return the middles of the bodies' bounding boxes, (b, 3) [m]."""
        boxes = [bounding_box(body.shape) for body in self.bodies]
        return np.array(
            [
                where.translation + where.rotation @ ((low + high) / 2.0)
                for where, (low, high) in zip(self.placements(positions), boxes, strict=True)
            ]
        )

    def distance(self, placements: Sequence[Placement], shape: to.Box, where: Placement) -> float:
        """Return the least distance of bodies at placements from a box; not above 0 where they touch [m]."""
        geometry = collision_geometry(shape)
        request, found = coal.DistanceRequest(), coal.DistanceResult()
        other, least = coal.Transform3s(where.rotation, where.translation), np.inf
        for body, at in zip(self.bodies, placements, strict=True):
            found.clear()
            mine = coal.Transform3s(at.rotation, at.translation)
            least = min(
                least,
                coal.distance(collision_geometry(body.shape), mine, geometry, other, request, found),
            )
        return float(least)


def instances(data: Path, robot: str) -> dict[str, Instance]:
    """Return a robot's problems by key."""
    folder = data / robot / "robot"
    loaded = (
        to.load("panda")
        if robot == "panda"
        else to.Robot.from_urdf(folder / f"{robot}.urdf", srdf=folder / f"{robot}.srdf")
    )
    return {f"{robot}/{item.name}": item for item in find_instances(data / robot, loaded)}


def generator(key: str) -> np.random.Generator:
    """Return the random numbers of a problem."""
    robot, name, number = key.split("/")
    return np.random.default_rng((SEED, ROBOTS.index(robot), zlib.crc32(name.encode()), int(number)))


def drawn(key: str, problem: to.Problem, still: to.Trajectory) -> Crossing | None:
    """Draw the box of a problem; None if no draw of `DRAWS` hits as it must.

    Args:
        key: Of the problem.
        problem: The still problem.
        still: Its verified motion.
    """
    rng, arm = generator(key), Arm(problem.reduced)
    path = np.array([arm.middles(q) for q in still(np.linspace(0.0, still.duration, 21))])
    travel = np.linalg.norm(np.diff(path, axis=0), axis=2).sum(axis=0)
    choice = np.flatnonzero(travel >= TRAVEL)
    choice = choice if len(choice) else np.array((int(travel.argmax()),))
    carried = np.array([body.joint for body in arm.bodies])
    begin = arm.placements(still(0.0))
    for _ in range(DRAWS):
        moment = float(rng.uniform(0.0, still.duration))
        joint = rng.choice(np.unique(carried[choice]))
        body = int(rng.choice(choice[carried[choice] == joint]))
        sides, orientation = rng.uniform(*SIDES, 3), rng.normal(size=4)
        direction, speed = rng.normal(size=3), float(rng.uniform(*SPEEDS))
        at = still(moment)
        crossing = Crossing(
            key,
            _rounded(sides),
            _rounded(orientation / np.linalg.norm(orientation)),
            _rounded(arm.middles(at)[body]),
            _rounded(speed * direction / np.linalg.norm(direction)),
            round(moment, 6),
            round(still.duration, 6),
            arm.bodies[body].owner,
        )
        hits = arm.distance(arm.placements(at), crossing.shape, crossing.placement(moment)) <= 0.0
        if hits and arm.distance(begin, crossing.shape, crossing.placement(0.0)) >= CLEAR:
            return crossing
    return None


def _rounded(values: np.ndarray) -> tuple[float, ...]:
    return tuple(round(float(value), 6) for value in values)


def crossings(file: Path = FILE) -> dict[str, Crossing]:
    """Read the frozen boxes, by key."""
    rows = [json.loads(line) for line in file.read_text().splitlines()]
    found = [
        Crossing(**{name: tuple(value) if isinstance(value, list) else value for name, value in row.items()})
        for row in rows
    ]
    return {item.key: item for item in found}


def main() -> None:
    """Draw the boxes and write them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--every", type=int, default=1, help="each so many-th problem only")
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    lines: list[str] = []
    for robot in ROBOTS:
        for key, item in list(instances(given.data, robot).items())[:: given.every]:
            problem = item.make()
            result = to.plan(problem)
            found = drawn(key, problem, result.require().trajectory) if result.verified else None
            if found is None:
                print(f"{key}: none, {result.status.name}", flush=True)
            else:
                lines.append(json.dumps(asdict(found)))
    given.out.write_text("".join(f"{line}\n" for line in lines))
    print(f"{len(lines)} boxes in {given.out}")


if __name__ == "__main__":
    main()
