"""Measured clouds, as bytes with a request."""

import io
from dataclasses import replace
from tokenize import TokenError
from typing import Any, cast

import numpy as np

from trajopt.lab.perception import PointCloud, Sensing, perceive
from trajopt.server.operation import Answer
from trajopt.server.operations.edits import stand
from trajopt.server.operations.words import called
from trajopt.server.refusals import Refusal, Why
from trajopt.server.state import SessionState
from trajopt.server.watch import Watch
from trajopt.values.arrays import Floats
from trajopt.values.documents.document import Node
from trajopt.values.shapes.clouds.points import Points

MAGIC = b"\x93NUMPY"
"""First bytes of numpy's files. As numbers of a plain cloud they would be 220,000 km away."""
KINDS = ("<f4", "<f8")
COORDINATES = 3
CAMERA = "camera"
"""The name of a cloud that has none."""


def cloud(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Add a cloud of points to the scene, or replace the earlier cloud of that name.

    The body is float32 (little-endian) x, y, z of each point [m], or numpy's .npy of float32 or float64 with
    shape (n, 3) or more columns; application/octet-stream. The address has the arguments: `name`; `radius` of
    the ball of each point, in world coordinates [m]; or, without it, the arguments of `PointCloud`
    (`positions`, `frame`, `placement`, `nearest`, `farthest`, `spacing`) and of `Sensing` (`cell`, `padding`,
    `sigmas`, `known`), with which the robot itself is removed. `stamp` [s]: older measurements than the
    newest are ignored.
    """
    points = points_in(watch.attachment, watch.cloud)
    name = arguments["name"].text(CAMERA)
    stamp = arguments["stamp"].number() if arguments.has("stamp") else None
    if stamp is not None and stamp < state.stamps.get(name, -np.inf):
        return Answer({"taken": False, "points": len(points), "newest": state.stamps[name]})
    if arguments.has("radius"):
        arguments.only(("name", "stamp", "radius"))
        radius = arguments["radius"].number()
        measured = points[np.isfinite(points).all(axis=1)]
        scene = state.scene.with_cloud(name, Points(measured, radius) if len(measured) else None)
        told: dict[str, object] = {"balls": len(measured), "radius": radius}
    else:
        sensor, sensing = _sensor(arguments, points, state)
        seen = perceive(state.scene, sensor, sensing, name=name)
        scene = seen.scene
        told = {"balls": len(seen.cloud.keys), "radius": seen.cloud.radius.whole, **seen.cloud.counts}
    stamps = state.stamps if stamp is None else {**state.stamps, name: stamp}
    return Answer({"taken": True, "points": len(points), **told}, replace(state, scene=scene, stamps=stamps))


def points_in(data: bytes, most: int) -> Floats:
    """Return the points of a cloud, not all of them finite, shape (n, 3) [m].

    Args:
        data: float32 numbers, or numpy's .npy.
        most: Points that there may be.

    Raises:
        Refusal: If it is neither, or too many.
    """
    found = _of_numpy(data) if data.startswith(MAGIC) else _of_numbers(data)
    if len(found) > most:
        raise Refusal(Why.TOO_LARGE, f"a cloud has {most} points at most, not {len(found)}")
    return found[:, :COORDINATES].astype(np.float64)


def _of_numbers(data: bytes) -> Any:
    size = COORDINATES * 4
    if len(data) % size:
        raise Refusal(
            Why.MALFORMED, f"the cloud has {len(data)} bytes, and a point has {size}: x, y, z as float32"
        )
    return np.frombuffer(data, "<f4").reshape(-1, COORDINATES)


def _of_numpy(data: bytes) -> Any:
    """Read an .npy by its header, which is checked against the data."""
    stream, layout = io.BytesIO(data), cast("Any", np.lib.format)
    try:
        version = layout.read_magic(stream)
        read = layout.read_array_header_1_0 if version == (1, 0) else layout.read_array_header_2_0
        shape, fortran, kind = read(stream)
    except (ValueError, TypeError, SyntaxError, TokenError, RecursionError, MemoryError) as error:
        raise Refusal(Why.MALFORMED, f"the cloud is no .npy file: {error}") from error
    if fortran or kind.str not in KINDS or len(shape) != 2 or shape[1] < COORDINATES:
        raise Refusal(
            Why.MALFORMED,
            f"the cloud needs float32 or float64 in rows of x, y, z, and is {kind.str} of shape {shape}",
        )
    begin = stream.tell()
    if shape[0] < 0 or shape[0] * shape[1] * kind.itemsize != len(data) - begin:
        raise Refusal(
            Why.MALFORMED, f"the cloud says that it has shape {shape}, and has {len(data) - begin} bytes"
        )
    return np.frombuffer(data, kind, offset=begin).reshape(shape)


_SENSOR = ("frame", "placement", "nearest", "farthest", "spacing")
_SENSING = ("cell", "padding", "sigmas", "known")


def _sensor(arguments: Node, points: Floats, state: SessionState) -> tuple[PointCloud, Sensing]:
    """Return the measurement, and the parameters of its conversion to an obstacle."""
    arguments.only(("name", "stamp", "radius", "positions", *_SENSOR, *_SENSING))
    parts = [
        Node({key: each.value for key, each in arguments.members().items() if key in names}, arguments.path)
        for names in (_SENSOR, _SENSING)
    ]
    stood = stand(state, arguments["positions"]) if arguments.has("positions") else state
    return called(PointCloud, parts[0], points=points, positions=stood.positions), called(Sensing, parts[1])
