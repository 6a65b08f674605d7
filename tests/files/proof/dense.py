"""An independent check of a proof's statement at many times: it can only refute.

scipy interpolates, Coal measures distances, and Pinocchio computes torques.
"""

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from scipy.interpolate import BPoly
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from tests.files.proof.conftest import Document

Numbers = np.ndarray
RATES = ("velocity", "acceleration", "jerk")
TOUCH = 1e-6
"""Coal's distances may be off by this much [m]."""


def curve(statement: Document) -> Callable[..., Numbers]:
    """Return the coordinates, drives last, as a function of times and the order of a derivative."""
    motion = statement["motion"]
    rows = np.stack([np.array(row, dtype=float) for row in motion["values"]], axis=1)
    own = BPoly.from_derivatives(motion["times"], rows)
    driven = [by_pieces(each) for each in statement["drives"]]
    return lambda times, order=0: np.concatenate([each(times, order) for each in (own, *driven)], axis=-1)


def by_pieces(drive: Document) -> BPoly:
    """Return the polynomials of a drive, which has a time twice where it jumps."""
    times, rows = np.array(drive["times"], dtype=float), np.array(drive["values"], dtype=float)
    found = [
        BPoly.from_derivatives(times[place : place + 2], rows[:, place : place + 2].swapaxes(0, 1)).c
        for place in np.flatnonzero(np.diff(times) > 0.0)
    ]
    return BPoly(np.concatenate(found, axis=1), np.unique(times))


def placed(statement: Document, times: Numbers) -> tuple[Numbers, Numbers]:
    """Return rotations (t, j, 3, 3) and origins (t, j, 3) of the world's and all joints' frames."""
    q = curve(statement)(times)
    turns = [np.broadcast_to(np.eye(3), (len(times), 3, 3))]
    origins = [np.zeros((len(times), 3))]
    for joint in statement["joints"]:
        parent, at = joint["place"]["joint"], joint["factor"] * q[:, joint["coordinate"]] + joint["offset"]
        axis = np.array(joint["axis"], dtype=float)
        moved = at[:, None] * axis / np.linalg.norm(axis)
        fixed = rotation(joint["place"])
        turn = Rotation.from_rotvec(moved).as_matrix() if joint["turns"] else np.eye(3)
        slide = 0.0 if joint["turns"] else moved @ fixed.T
        local = np.array(joint["place"]["translation"]) + slide + np.zeros((len(times), 3))
        origins.append(origins[parent] + np.einsum("tij,tj->ti", turns[parent], local))
        turns.append(turns[parent] @ fixed @ turn)
    return np.stack(turns, 1), np.stack(origins, 1)


def rotation(place: Document) -> Numbers:
    w, x, y, z = place["rotation"]
    return Rotation.from_quat((x, y, z, w)).as_matrix()


def refuted(statement: Document, samples: int = 100) -> Iterator[str]:
    """Yield what does not hold at some sampled time."""
    times = np.linspace(0.0, statement["motion"]["times"][-1], samples)
    motion, excess = curve(statement), statement["excess"] + 1e-9
    for joint in statement["joints"]:
        at = joint["factor"] * motion(times)[:, joint["coordinate"]] + joint["offset"]
        for name, sign in (("lower", -1.0), ("upper", 1.0)):
            side = joint[name]
            if side is not None and (sign * (at - side) > excess * max(1.0, abs(side))).any():
                yield f"{joint['name']} passes its {name} limit"
        for order, name in enumerate(RATES, start=1):
            rate = abs(joint["factor"]) * np.abs(motion(times[1:-1], order)[:, joint["coordinate"]])
            if joint[name] is not None and (rate > joint[name] * (1.0 + excess)).any():
                yield f"{joint['name']} passes its limit of {name}"
    yield from _ends(statement, motion)
    yield from _heavy(statement, times)
    yield from _near(statement, times)


def _ends(statement: Document, motion: Callable[..., Numbers]) -> Iterator[str]:
    ends, own = statement["ends"], slice(len(statement["motion"]["coordinates"]))
    if (np.abs(motion(0.0)[own] - ends["positions"]) > ends["tolerance"] + 1e-12).any():
        yield "it starts elsewhere"
    if (np.abs(motion(0.0, 1)[own] - ends["velocities"]) > ends["speed"] + 1e-12).any():
        yield "it starts at another speed"
    for each in of_kind(statement, "joint positions"):
        for number, low, high in each["ranges"]:
            joint = statement["joints"][number - 1]
            at = (
                joint["factor"] * motion(statement["motion"]["times"][-1])[joint["coordinate"]]
                + joint["offset"]
            )
            slack = statement["excess"] + 1e-12
            if (low is not None and at < low - slack) or (high is not None and at > high + slack):
                yield f"joint {number} ends elsewhere"


def of_kind(statement: Document, kind: str) -> list[Document]:
    return [each for each in statement["requirements"] if each["kind"] == kind]


def _heavy(statement: Document, times: Numbers) -> Iterator[str]:
    for rule in of_kind(statement, "torque"):
        torque = np.abs(torques(statement, rule, times[1:-1]))
        for coordinate, limit in rule["limits"]:
            if (torque[:, coordinate] > limit * (1.0 + statement["excess"]) + 1e-9).any():
                yield f"the torque of coordinate {coordinate} passes its limit"


def torques(statement: Document, rule: Document, times: Numbers) -> Numbers:
    """Return the torques of all coordinates, (t, n), by Pinocchio's recursive Newton-Euler algorithm."""
    model, motion = heavy_model(statement, rule), curve(statement)
    follows = np.zeros((model.nv, motion(0.0).shape[-1]))
    for number, joint in enumerate(statement["joints"]):
        follows[number, joint["coordinate"]] = joint["factor"]
    offset, data = np.array([joint["offset"] for joint in statement["joints"]]), model.createData()
    state = [motion(times, order) @ follows.T for order in range(3)]
    state[0] = state[0] + offset
    return np.array([pin.rnea(model, data, *each) for each in zip(*state, strict=True)]) @ follows


def heavy_model(statement: Document, rule: Document) -> pin.Model:
    model = pin.Model()
    for joint in statement["joints"]:
        kind = pin.JointModelRevoluteUnaligned if joint["turns"] else pin.JointModelPrismaticUnaligned
        axis = np.array(joint["axis"], dtype=float)
        place = pin.SE3(rotation(joint["place"]), np.array(joint["place"]["translation"], dtype=float))
        moves = kind(axis / np.linalg.norm(axis))
        model.addJoint(joint["place"]["joint"], moves, place, f"{len(model.names)} {joint['name']}")
    for number, mass, centre, (xx, xy, xz, yy, yz, zz) in rule["loads"]:
        load = pin.Inertia(float(mass), np.array(centre), np.zeros((3, 3)))
        load.inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])  # mutations may make it negative
        model.inertias[number] += load
    model.armature = np.array(rule["rotors"], dtype=float)
    model.gravity.linear = np.array(rule["gravity"], dtype=float)
    return model


def _near(statement: Document, times: Numbers) -> Iterator[str]:
    turns, origins = placed(statement, times)
    parts = statement["parts"]
    for one, other, required in statement["pairs"]:
        for place in there(statement, [parts[part]["owner"] for part in (one, other)], times):
            shapes = [shape(freeze(parts[part]["shape"])) for part in (one, other)]
            spots = [at(parts[part]["place"], turns[place], origins[place]) for part in (one, other)]
            request, result = coal.DistanceRequest(), coal.DistanceResult()
            distance = coal.distance(shapes[0][0], spots[0], shapes[1][0], spots[1], request, result)
            error = sum(error_at(statement, parts[part]["owner"], times[place]) for part in (one, other))
            if distance - shapes[0][1] - shapes[1][1] < required + error - TOUCH:
                yield f"{parts[one]['owner']} and {parts[other]['owner']} at {times[place]:.4f} s"
                return


def there(statement: Document, owners: list[str], times: Numbers) -> list[int]:
    """Return the places of the times at which all of some owners are there."""
    present = np.ones(len(times), dtype=bool)
    for owner, appears, expires, _ in statement["changes"]:
        if owner in owners:
            present &= times > (-np.inf if appears is None else appears)
            present &= times < (np.inf if expires is None else expires)
    return np.flatnonzero(present).tolist()


def error_at(statement: Document, owner: str, time: float) -> float:
    errors = [error for name, _, _, error in statement["changes"] if name == owner]
    return sum(r + v * time + a * time**2 / 2.0 for r, v, a in errors)


def at(place: Document, turns: Numbers, origins: Numbers) -> coal.Transform3s:
    turn, joint = turns[place["joint"]], place["joint"]
    return coal.Transform3s(turn @ rotation(place), origins[joint] + turn @ np.array(place["translation"]))


def freeze(value: Any) -> Any:
    """Return plain data as something that can be hashed."""
    if isinstance(value, dict):
        return tuple((key, freeze(value[key])) for key in sorted(value))
    return tuple(map(freeze, value)) if isinstance(value, list) else value


@cache
def shape(frozen: Any) -> tuple[coal.CollisionGeometry, float]:
    """Return a convex shape inside of a stated one, and the radius around it."""
    stated = dict(frozen)
    if stated["kind"] == "frustum":
        angles = np.linspace(0.0, 2.0 * np.pi, 65)[:-1]
        rims = [
            np.stack((r * np.cos(angles), r * np.sin(angles), np.full(64, z)), 1)
            for r, z in ((stated["bottom"], -stated["length"] / 2), (stated["top"], stated["length"] / 2))
        ]
        return hull(np.vstack(rims)), 0.0
    vertices = np.array(stated["vertices"], dtype=float)
    if len(vertices) == 1:
        return coal.Sphere(1e-12), stated["radius"]
    return hull(vertices), stated["radius"]


def hull(points: Numbers) -> coal.CollisionGeometry:
    found = ConvexHull(points, qhull_options="QJ")
    vertices, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    vertices.extend(points)
    faces.extend([coal.Triangle(*map(int, face)) for face in found.simplices])
    return coal.Convex(vertices, faces)
