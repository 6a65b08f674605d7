"""An independent check of a proof's statement at many times: it can only refute.

scipy interpolates, Coal measures distances, and Pinocchio computes torques.
"""

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from scipy.interpolate import BPoly
from scipy.optimize import nnls
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
    yield from _unmet(statement, times)
    yield from _left_out(statement)
    yield from _near(statement, times)


def _ends(statement: Document, motion: Callable[..., Numbers]) -> Iterator[str]:
    ends, own = statement["ends"], slice(len(statement["motion"]["coordinates"]))
    if (np.abs(motion(0.0)[own] - ends["positions"]) > ends["tolerance"] + 1e-12).any():
        yield "it starts elsewhere"
    if (np.abs(motion(0.0, 1)[own] - ends["velocities"]) > ends["speed"] + 1e-12).any():
        yield "it starts at another speed"
    last = statement["motion"]["times"][-1]
    if ends["rests"] and (np.abs(motion(last, 1)[own]) > ends["speed"] + 1e-12).any():
        yield "it does not end at rest"
    start = motion(0.0, 2)[own] - ends["accelerations"]
    if any(ends["accelerations"]) and (np.abs(start) > ends["speed"] + 1e-9).any():
        yield "it starts with another acceleration"
    jumps = [start, motion(last, 2)[own] * ends["rests"]]
    for joint in statement["joints"]:
        if joint["jerk"] is not None:
            jump = max(abs(joint["factor"] * each[joint["coordinate"]]) for each in jumps)
            scale = joint["jerk"] if joint["acceleration"] is None else joint["acceleration"]
            if jump > statement["excess"] * scale + 1e-9:
                yield f"the acceleration of {joint['name']} jumps"


def _unmet(statement: Document, times: Numbers) -> Iterator[str]:
    """Yield requirements, but for torque, that do not hold at some time."""
    for each in statement["requirements"]:
        rule, when = each, times if each.get("always", each["kind"] in ALWAYS) else times[-1:]
        if each["kind"] == "waypoint":
            rule, when = each["requirement"], np.array([each["time"]])
        if each["kind"] == "part":
            rule, when = each["requirement"], times[(times >= each["since"]) & (times <= each["until"])]
        if (
            rule["kind"] in EXCEEDED
            and len(when)
            and (EXCEEDED[rule["kind"]](statement, rule, when) > 1e-9).any()
        ):
            yield f"{each['kind']} is not met"


ALWAYS = ("tool speed", "angular speed", "held placement", "rest", "steady speed")


def _restless(statement: Document, rule: Document, times: Numbers) -> Numbers:
    """Return by how much the motion is too late, or too fast at rest."""
    by = np.inf if rule["by"] is None else rule["by"]
    late = rule["since"] - min(by, times[-1])
    own = slice(len(statement["motion"]["coordinates"]))
    speeds = np.abs(curve(statement)(times[times > rule["since"]], 1)[:, own])
    return np.array(
        [late, 0.0 if statement["ends"]["rests"] else np.inf, *(speeds.ravel() - statement["ends"]["speed"])]
    )


def _unsteady(statement: Document, rule: Document, times: Numbers) -> Numbers:
    """Return by how much a speed is too low, and the way outside of its span too long."""
    inner = times[1:-1]
    speed, error = _speeds(statement, rule, inner)
    inside = (inner >= rule["since"]) & (inner <= rule["until"])
    low = rule["least"] - statement["excess"] - 1e-6 - error[inside] - speed[inside] * (1.0 + 1e-6)
    share = speed[inside].sum() / max(speed.sum(), 1e-12)
    return np.array([*low, 0.45 - share - error.max()])


def _off_range(statement: Document, rule: Document, times: Numbers) -> Numbers:
    coordinates = curve(statement)(times)
    off = [np.zeros(len(times))]
    for number, low, high in rule["ranges"]:
        joint = statement["joints"][number - 1]
        at = joint["factor"] * coordinates[:, joint["coordinate"]] + joint["offset"] - statement["excess"]
        off += [] if high is None else [at - high]
        off += [] if low is None else [low - at - 2.0 * statement["excess"]]
    return np.max(off, axis=0)


def _off_axis(statement: Document, rule: Document, times: Numbers) -> Numbers:
    turns, _ = placed(statement, times)
    axis, along = (np.array(rule[name], dtype=float) for name in ("axis", "direction"))
    seen = [turns[:, rule["joint"]] @ (axis / np.linalg.norm(axis)), turns[:, rule["reference"]] @ along]
    aside = np.linalg.norm(np.cross(*seen), axis=1)
    return np.arctan2(aside, np.einsum("ti,ti->t", *seen)) - rule["tolerance"] - statement["excess"]


def _out_of_region(statement: Document, rule: Document, times: Numbers) -> Numbers:
    _, point = _posed(statement, rule["place"], times)
    depth: list[Numbers] = []
    for kind, sizes, place in rule["members"]:
        turn, origin = _posed(statement, place, times)
        local = np.einsum("tij,ti->tj", turn, point - origin)
        depth.append(DEPTHS[kind](local, np.array(sizes, dtype=float)))
    return np.min(depth, axis=0) - statement["excess"]


DEPTHS: dict[str, Callable[[Numbers, Numbers], Numbers]] = {
    "box": lambda local, sizes: (np.abs(local) - sizes / 2.0).max(axis=1),
    "sphere": lambda local, sizes: np.linalg.norm(local, axis=1) - sizes[0],
    "cylinder": lambda local, sizes: np.maximum(
        np.linalg.norm(local[:, :2], axis=1) - sizes[0], np.abs(local[:, 2]) - sizes[1] / 2.0
    ),
    "half-space": lambda local, _: local[:, 2],
}
"""Shapes -> how far points are outside, negative inside."""


def _misplaced(statement: Document, rule: Document, times: Numbers) -> Numbers:
    (turn, origin), (goal, middle) = (_posed(statement, rule[name], times) for name in ("place", "goal"))
    off = np.einsum("tij,ti->tj", goal, origin - middle)
    vector = Rotation.from_matrix(goal.swapaxes(1, 2) @ turn).as_rotvec()
    most = [np.inf if size is None else size for size in (*rule["position"], *rule["rotation"])]
    return (np.abs(np.hstack((off, vector))) - most).max(axis=1) - statement["excess"]


def _too_fast(statement: Document, rule: Document, times: Numbers) -> Numbers:
    speed, error = _speeds(statement, rule, times[1:-1])
    return speed * (1.0 - 1e-6) - error - rule["limit"] - statement["excess"] - 1e-6


def _turning_too_fast(statement: Document, rule: Document, times: Numbers) -> Numbers:
    step, inner = 1e-5, times[1:-1]
    turns = [_posed(statement, rule["place"], inner + side)[0] for side in (-step, step)]
    moved = Rotation.from_matrix(turns[1] @ turns[0].swapaxes(1, 2)).as_rotvec()
    speed = np.linalg.norm(moved, axis=1) / (2.0 * step)
    return speed * (1.0 - 1e-6) - rule["limit"] - statement["excess"] - 1e-6


def _speeds(statement: Document, rule: Document, times: Numbers) -> tuple[Numbers, Numbers]:
    """Return speeds of a point by differences, and the largest error by rounding, of a far point."""
    step = 1e-5
    ends = [_posed(statement, rule["place"], times + side)[1] for side in (-step, step)]
    error = 1e-14 * np.abs(ends).max(axis=(0, 2)) / step
    return np.linalg.norm(ends[1] - ends[0], axis=1) / (2.0 * step), error


def _outside_parts(statement: Document, rule: Document, _: Numbers) -> Numbers:
    """Return by how much a ball or cube of a cloud passes its part along one of many directions."""
    directions = np.random.default_rng(0).standard_normal((200, 3))
    directions = np.concatenate(
        (directions / np.linalg.norm(directions, axis=1)[:, None], np.eye(3), -np.eye(3))
    )
    reach = rule["size"] * (np.abs(directions).sum(axis=1) if rule["cubes"] else np.ones(len(directions)))
    off = [0.0]
    for number, centres in rule["inside"]:
        part = statement["parts"][number]
        if part["owner"] != rule["owner"] or part["shape"]["kind"] != "hull":
            return np.array([np.inf])
        most = (directions @ np.array(part["shape"]["vertices"], dtype=float).T).max(axis=1) + part["shape"][
            "radius"
        ]
        off.append(((directions @ np.array(centres, dtype=float).T).max(axis=1) + reach - most).max())
    return np.array([max(off)])


EXCEEDED: dict[str, Callable[[Document, Document, Numbers], Numbers]] = {
    "joint positions": _off_range,
    "axis alignment": _off_axis,
    "position in region": _out_of_region,
    "frame placement": _misplaced,
    "tool speed": _too_fast,
    "angular speed": _turning_too_fast,
    "cloud": _outside_parts,
    "held placement": _misplaced,
    "rest": _restless,
    "steady speed": _unsteady,
}
"""Kinds of requirements -> by how much each is exceeded at times."""


def _posed(statement: Document, place: Document, times: Numbers) -> tuple[Numbers, Numbers]:
    turns, origins = placed(statement, times)
    turn = turns[:, place["joint"]]
    return turn @ rotation(place), origins[:, place["joint"]] + turn @ np.array(place["translation"])


def _left_out(statement: Document) -> Iterator[str]:
    """Yield parts that the robot moves against each other, and that are neither a pair nor excused."""
    joints, own = statement["joints"], len(statement["motion"]["coordinates"])
    moved = [False]
    for joint in joints:
        moved.append(moved[joint["place"]["joint"]] or joint["coordinate"] < own)
    listed = {frozenset(pair[:2]) for pair in statement["pairs"]}
    excused = {frozenset(row[:2]) for row in statement["excused"]}
    for one, first in enumerate(statement["parts"]):
        for other, second in enumerate(statement["parts"][:one]):
            owners = frozenset((first["owner"], second["owner"]))
            on = first["place"]["joint"], second["place"]["joint"]
            due = len(owners) == 2 and on[0] != on[1] and (moved[on[0]] or moved[on[1]])
            if due and owners not in excused and frozenset((one, other)) not in listed:
                yield f"{' and '.join(owners)} are left out"


def of_kind(statement: Document, kind: str) -> list[Document]:
    return [each for each in statement["requirements"] if each["kind"] == kind]


def _heavy(statement: Document, times: Numbers) -> Iterator[str]:
    for rule in (*of_kind(statement, "torque"), *of_kind(statement, "gravity torque")):
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
    state = [
        motion(times, order) @ follows.T * (order == 0 or rule["kind"] == "torque") for order in range(3)
    ]
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
    shapes = [shape(freeze(part["shape"])) for part in parts]
    centres = [
        _centres(part, turns, origins, geometry) for part, (geometry, _) in zip(parts, shapes, strict=True)
    ]
    for one, other, required in statement["pairs"]:
        owners = [parts[part]["owner"] for part in (one, other)]
        present = there(statement, owners, times)
        needed = required + sum(error_at(statement, owner, times) for owner in owners) - TOUCH
        needed = needed + shapes[one][1] + shapes[other][1]
        reach = shapes[one][0].aabb_radius + shapes[other][0].aabb_radius
        far = np.linalg.norm(centres[one] - centres[other], axis=1) - reach >= needed
        for place in np.flatnonzero(~far & present).tolist():
            spots = [at(parts[part]["place"], turns[place], origins[place]) for part in (one, other)]
            request, result = coal.DistanceRequest(), coal.DistanceResult()
            distance = coal.distance(shapes[one][0], spots[0], shapes[other][0], spots[1], request, result)
            if distance < needed[place] and _meet(
                shapes[one][0], spots[0], shapes[other][0], spots[1], needed[place]
            ):
                yield f"{' and '.join(owners)} at {times[place]:.4f} s"
                break


def _meet(
    one: coal.CollisionGeometry,
    at_one: coal.Transform3s,
    other: coal.CollisionGeometry,
    at_other: coal.Transform3s,
    needed: float,
) -> bool:
    """Return whether two shapes have points that are nearer than a distance: Coal may err for huge shapes.

    The points are convex combinations of vertices, of least squares with weights that are not negative.
    """
    if isinstance(one, coal.Halfspace) or isinstance(other, coal.Halfspace):
        return True
    sides = [
        np.asarray(shape.points()) @ place.getRotation().T + place.getTranslation()
        for shape, place in ((one, at_one), (other, at_other))
    ]
    middle = np.median(np.vstack(sides), axis=0)
    first, second = (side - middle for side in sides)
    scale = 1.0 + max(np.abs(first).max(), np.abs(second).max())
    rows = np.hstack((first.T, -second.T)) / scale
    ones = np.repeat(np.eye(2), [len(first), len(second)], axis=1)
    weights, _ = nnls(np.vstack((rows, ones)), np.array((0.0, 0.0, 0.0, 1.0, 1.0)))
    shares = weights[: len(first)], weights[len(first) :]
    if min(share.sum() for share in shares) < 0.5:
        return False
    points = [(share / share.sum()) @ side for share, side in zip(shares, (first, second), strict=True)]
    return bool(np.linalg.norm(points[0] - points[1]) < needed + 1e-9)


def _centres(part: Document, turns: Numbers, origins: Numbers, geometry: coal.CollisionGeometry) -> Numbers:
    place = part["place"]
    centre = geometry.aabb_center if np.isfinite(geometry.aabb_radius) else np.zeros(3)
    local = rotation(place) @ centre + np.array(place["translation"])
    return origins[:, place["joint"]] + turns[:, place["joint"]] @ local


def there(statement: Document, owners: list[str], times: Numbers) -> Numbers:
    """Return at which times all of some owners are there."""
    present = np.ones(len(times), dtype=bool)
    for owner, appears, expires, _ in statement["changes"]:
        if owner in owners:
            present &= times > (-np.inf if appears is None else appears)
            present &= times < (np.inf if expires is None else expires)
    for one, other, since, until in statement["contacts"]:
        if {one, other} == set(owners):
            present &= times > (-np.inf if since is None else since)
            present &= times < (np.inf if until is None else until)
    return present


def error_at(statement: Document, owner: str, time: Numbers) -> Numbers:
    errors = [error for name, _, _, error in statement["changes"] if name == owner]
    return sum((r + v * time + a * time**2 / 2.0 for r, v, a in errors), np.zeros(len(time)))


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
    found, radius = _shape(dict(frozen))
    found.computeLocalAABB()
    return found, radius


def _shape(stated: Document) -> tuple[coal.CollisionGeometry, float]:
    if stated["kind"] == "half-space":
        return coal.Halfspace(np.array((0.0, 0.0, 1.0)), 0.0), 0.0
    if stated["kind"] == "frustum":
        angles = np.linspace(0.0, 2.0 * np.pi, 65)[:-1]
        rims = [
            np.stack((r * np.cos(angles), r * np.sin(angles), np.full(64, z)), 1)
            for r, z in ((stated["bottom"], -stated["length"] / 2), (stated["top"], stated["length"] / 2))
        ]
        return hull(np.vstack(rims)), 0.0
    vertices = np.array(stated["vertices"], dtype=float)
    if len(vertices) < 4:
        return convex(np.repeat(vertices, 4, axis=0), itertools.combinations(range(4), 3)), stated["radius"]
    return hull(vertices), stated["radius"]


def hull(points: Numbers) -> coal.CollisionGeometry:
    return convex(points, ConvexHull(points, qhull_options="QJ").simplices.tolist())


def convex(points: Numbers, triangles: Iterable[Sequence[int]]) -> coal.CollisionGeometry:
    vertices, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    vertices.extend(points)
    faces.extend([coal.Triangle(*face) for face in triangles])
    return coal.Convex(vertices, faces)
