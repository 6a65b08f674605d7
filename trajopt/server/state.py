"""Content of a session: a scene and its robot's positions, and their form as bytes.

The process that communicates with clients never reads these bytes; only workers do.
"""

import pickle
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import blake2b
from io import BytesIO
from typing import Any, cast

from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value
from trajopt.values.errors.arguments import checked


@checked
@dataclass(frozen=True, eq=False)
class SessionState(Value):
    """A robot among objects, and its positions.

    Attributes:
        robot: Name of the robot on the server.
        scene: Its surroundings.
        positions: Of all joints, shape (number of joints,) [rad | m].
        stamps: Measurement times of clouds in the scene, by name, on their sensors' clocks [s].
    """

    robot: str
    scene: Scene
    positions: Floats
    stamps: Mapping[str, float] = field(default_factory=dict[str, float])

    @property
    def named_positions(self) -> dict[str, float]:
        """Positions of all joints, by name [rad | m]."""
        return dict(zip(self.scene.robot.joint_names, self.positions.tolist(), strict=True))


@dataclass(frozen=True)
class PackedScene(Value):
    """A scene as bytes.

    Attributes:
        robot: Name by which the server knows the robot.
        data: The scene.
        key: The same for the same bytes.
    """

    robot: str
    data: bytes
    key: bytes

    @staticmethod
    def of(robot: str, data: bytes) -> "PackedScene":
        """Return bytes with their key."""
        return PackedScene(robot, data, blake2b(data, digest_size=16).digest())


def packed(state: SessionState, robots: Mapping[str, Robot]) -> PackedScene:
    """Return the scene of a state as bytes; robots that every worker has are named in them, not held."""
    names = {id(robot): name for name, robot in robots.items()}

    class Pickler(pickle.Pickler):
        def persistent_id(self, obj: Any) -> str | None:
            return names.get(id(obj)) if isinstance(obj, Robot) else None

    buffer = BytesIO()
    Pickler(buffer, pickle.HIGHEST_PROTOCOL).dump(state.scene)
    return PackedScene.of(state.robot, buffer.getvalue())


def unpacked(scene: PackedScene, robots: Mapping[str, Robot]) -> Scene:
    """Return the scene of `packed`.

    Args:
        scene: A result of `packed`, from this process or another of the same server; nothing else.
        robots: The robots by name, with which it was packed.
    """

    class Unpickler(pickle.Unpickler):
        def persistent_load(self, pid: Any) -> Robot:
            return robots[pid]

    return cast(Scene, Unpickler(BytesIO(scene.data)).load())
