"""Find MotionBenchMaker problems with a valid start and goal, by code that shares nothing with the planner.

python -m benchmarks.askable DATA/fetch [--urdf FILE --srdf FILE --packages FOLDER] [--limit K] [--json FILE]

DATA/<robot> holds <set>/sceneNNNN.yaml and requestNNNN.yaml in MoveIt's YAML, and robot/ with one URDF, one
SRDF and the meshes. A problem is askable if at its start and at its goal the joints of the goal are within
their limits, nothing touches (Coal, on the primitives and on the meshes' own triangles), and the joints hold
the load of gravity within their effort limits (Pinocchio; an effort of 0 is one that is not stated).

Pairs of links that the SRDF lets touch may touch, and pairs that adjoin; where the scene's matrix names both
links, it decides. Positions of joints that the URDF fixes or does not have are ignored. A thing wholly inside
a link's mesh is not seen, for a surface has no inside.
"""

import argparse
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import combinations
from pathlib import Path
from xml.etree import ElementTree

import coal
import numpy as np
import pinocchio as pin
import yaml

ROUNDING = 1e-5
"""What printing a limit may cost [rad, m]: a URDF that writes pi as 3.14159 is 2.7e-6 short of it."""

Pair = frozenset[str]


@dataclass(frozen=True)
class Body:
    """A shape on a link, by the number of the link's frame in Pinocchio; in the world where that is -1."""

    owner: str
    frame: int
    place: pin.SE3
    shape: coal.CollisionGeometry


@dataclass(frozen=True)
class Machine:
    """A robot: its model, the bodies of its links, and the pairs of links that may touch."""

    model: pin.Model
    bodies: tuple[Body, ...]
    allowed: frozenset[Pair]


@dataclass(frozen=True)
class Asked:
    """A problem: positions by joint at start and goal, surroundings, allowed collisions."""

    start: Mapping[str, float]
    goal: Mapping[str, float]
    things: tuple[Body, ...]
    matrix: Mapping[Pair, bool]


def main() -> None:
    """Print why each problem of a robot is not answerable, and count."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--urdf", type=Path)
    parser.add_argument("--srdf", type=Path)
    parser.add_argument("--packages", type=Path, help="folder against which package:// is resolved")
    parser.add_argument("--limit", type=int, help="problems of each set at most")
    parser.add_argument("--json", type=Path, help="write set/number -> reasons here")
    given = parser.parse_args()
    machine = read_machine(
        given.urdf or only(given.folder / "robot", "urdf"),
        given.srdf or only(given.folder / "robot", "srdf"),
        given.packages or given.folder / "robot",
    )
    found = {name: faults(machine, *files) for name, files in problems(given.folder, given.limit).items()}
    for name, reasons in found.items():
        if reasons:
            print(f"{name}: {'; '.join(reasons)}")
    print(f"{sum(not reasons for reasons in found.values())} of {len(found)} can be asked")
    if given.json is not None:
        given.json.write_text(json.dumps(found, indent=1) + "\n")


def only(folder: Path, kind: str) -> Path:
    """Return the one file of a kind in a folder."""
    (found,) = folder.glob(f"*.{kind}")
    return found


def problems(folder: Path, limit: int | None = None) -> dict[str, tuple[Path, Path]]:
    """Return set/number -> scene and request."""
    sets = sorted({scene.parent for scene in folder.glob("*/scene*.yaml")})
    return {
        f"{name.name}/{int(re.sub(r'[^0-9]', '', scene.stem))}": (
            scene,
            scene.with_name(scene.name.replace("scene", "request")),
        )
        for name in sets
        for scene in sorted(name.glob("scene*.yaml"))[:limit]
    }


def faults(machine: Machine, scene: Path, request: Path) -> list[str]:
    """Return why a problem is not answerable, in words; empty if it is."""
    asked = read_problem(machine, scene, request)
    return [
        f"{what}: {fault}"
        for what, at in (("start", asked.start), ("goal", {**asked.start, **asked.goal}))
        for fault in _faults(machine, asked, at)
    ]


def _faults(machine: Machine, asked: Asked, at: Mapping[str, float]) -> Iterator[str]:
    model, moved = machine.model, [name for name in asked.goal if machine.model.existJointName(name)]
    for name in moved:
        joint = model.joints[model.getJointId(name)]
        if joint.nq == 1 and not (
            model.lowerPositionLimit[joint.idx_q] - ROUNDING
            <= at[name]
            <= model.upperPositionLimit[joint.idx_q] + ROUNDING
        ):
            yield f"{name} at {at[name]:.6g} is outside its limits"
    data, positions = model.createData(), configuration(model, at)
    torque = pin.computeGeneralizedGravity(model, data, positions)
    for name in moved:
        place = model.joints[model.getJointId(name)].idx_v
        most, load = float(model.effortLimit[place]), abs(float(torque[place]))
        if 0.0 < most < load:
            yield f"{name} needs {load:.5g} to hold its load, its effort limit is {most:g}"
    pin.framesForwardKinematics(model, data, positions)
    placed = [(body, where(data, body)) for body in (*machine.bodies, *asked.things)]
    for (first, one), (second, other) in combinations(placed, 2):
        if not may_touch(machine, asked, first, second) and coal.collide(
            first.shape, one, second.shape, other, coal.CollisionRequest(), coal.CollisionResult()
        ):
            yield f"{first.owner} touches {second.owner}"


def configuration(model: pin.Model, at: Mapping[str, float]) -> np.ndarray:
    """Return Pinocchio's configuration; joints that are not named stand at 0, or as near as they can."""
    positions = pin.neutral(model)
    for name, number in zip(model.names[1:], range(1, model.njoints), strict=True):
        joint = model.joints[number]
        if joint.nq == 2:
            positions[joint.idx_q : joint.idx_q + 2] = np.cos(at.get(name, 0.0)), np.sin(at.get(name, 0.0))
        else:
            low, high = (side[joint.idx_q] for side in (model.lowerPositionLimit, model.upperPositionLimit))
            positions[joint.idx_q] = at.get(name, float(np.clip(0.0, low, high)))
    return positions


def where(data: pin.Data, body: Body) -> coal.Transform3s:
    """Return where a body is."""
    place = body.place if body.frame < 0 else data.oMf[body.frame] * body.place
    return coal.Transform3s(place.rotation, place.translation)


def may_touch(machine: Machine, asked: Asked, first: Body, second: Body) -> bool:
    """Say whether two bodies need not keep apart."""
    if first.frame < 0 and second.frame < 0:
        return True
    frames = machine.model.frames
    joints = {frames[body.frame].parentJoint if body.frame >= 0 else 0 for body in (first, second)}
    if first.owner == second.owner or len(joints) == 1:
        return True  # neither can move against the other: not for the motion to change
    pair = frozenset((first.owner, second.owner))
    return asked.matrix.get(pair, pair in machine.allowed)


@cache
def read_machine(urdf: Path, srdf: Path, packages: Path) -> Machine:
    """Read a robot."""
    model = pin.buildModelFromUrdf(str(urdf))
    root = ElementTree.parse(urdf).getroot()
    bodies = tuple(
        Body(
            link.get("name", ""),
            model.getFrameId(link.get("name", ""), pin.FrameType.BODY),
            _origin(item),
            _shape(item.find("geometry")[0], packages),
        )
        for link in root.findall("link")
        for item in link.findall("collision")
    )
    pairs = {
        frozenset((item.get("link1", ""), item.get("link2", "")))
        for item in ElementTree.parse(srdf).getroot().findall("disable_collisions")
    }
    adjoin = {
        frozenset((joint.find("parent").get("link"), joint.find("child").get("link")))
        for joint in root.findall("joint")
    }
    return Machine(model, bodies, frozenset(pairs | adjoin))


def _origin(element: ElementTree.Element) -> pin.SE3:
    origin = element.find("origin")
    if origin is None:
        return pin.SE3.Identity()
    turn, shift = (np.array(origin.get(key, "0 0 0").split(), dtype=float) for key in ("rpy", "xyz"))
    return pin.SE3(pin.rpy.rpyToMatrix(*turn), shift)


def _shape(element: ElementTree.Element, packages: Path) -> coal.CollisionGeometry:
    """Return a URDF's shape; a mesh as its triangles."""
    if element.tag == "box":
        return coal.Box(*(float(size) for size in element.get("size", "").split()))
    if element.tag == "sphere":
        return coal.Sphere(float(element.get("radius", "")))
    if element.tag == "cylinder":
        return coal.Cylinder(float(element.get("radius", "")), float(element.get("length", "")))
    if element.tag != "mesh":
        raise ValueError(f"unknown shape <{element.tag}>")
    scale = np.array(element.get("scale", "1 1 1").split(), dtype=float)
    name = element.get("filename", "").removeprefix("package://")
    return coal.MeshLoader().load(str(packages / name), scale)


def read_problem(machine: Machine, scene: Path, request: Path) -> Asked:
    """Read a scene and its request."""
    told, wanted = (yaml.load(file.read_bytes(), yaml.CSafeLoader) for file in (scene, request))
    (goal,) = wanted["goal_constraints"]
    if set(goal) != {"joint_constraints"}:
        raise ValueError(f"{request}: the goal is not one of joints alone")
    for state in (told["robot_state"], wanted["start_state"]):
        for transform in state.get("multi_dof_joint_state", {}).get("transforms", []):
            if transform != {"rotation": [0, 0, 0, 1], "translation": [0, 0, 0]}:
                raise ValueError(f"{request}: the base is moved by {transform}")
    start = wanted["start_state"]["joint_state"]
    return Asked(
        dict(zip(start["name"], start["position"], strict=True)),
        {item["joint_name"]: float(item["position"]) for item in goal["joint_constraints"]},
        tuple(
            thing for item in told["world"]["collision_objects"] for thing in _things(machine, item, scene)
        ),
        _matrix(told["allowed_collision_matrix"]),
    )


def _things(machine: Machine, told: Mapping[str, object], scene: Path) -> Iterator[Body]:
    if set(told) - {"id", "header", "pose", "primitives", "primitive_poses"}:
        raise ValueError(f"{scene}: {told['id']} has more than primitives: {sorted(told)}")
    frame = told.get("header", {}).get("frame_id", "")
    if frame not in ("", "world", machine.model.frames[1].name):
        raise ValueError(f"{scene}: {told['id']} is given in {frame}, which is not the robot's root")
    base = _pose(told["pose"]) if "pose" in told else pin.SE3.Identity()
    for shape, pose in zip(told["primitives"], told["primitive_poses"], strict=True):
        yield Body(str(told["id"]), -1, base * _pose(pose), _primitive(shape["type"], shape["dimensions"]))


def _pose(told: Mapping[str, list[float]]) -> pin.SE3:
    turn = pin.Quaternion(np.array(told["orientation"], dtype=float))  # x, y, z, w
    return pin.SE3(turn.normalized().matrix(), np.array(told["position"], dtype=float))


def _primitive(kind: str, sizes: list[float]) -> coal.CollisionGeometry:
    if kind == "box":
        return coal.Box(*sizes)
    if kind == "sphere":
        return coal.Sphere(*sizes)
    if kind == "cylinder":
        height, radius = sizes
        return coal.Cylinder(radius, height)
    raise ValueError(f"unknown primitive {kind}")


def _matrix(told: Mapping[str, list]) -> dict[Pair, bool]:
    """Return which pairs the scene's matrix names, and whether each may touch."""
    names, values = told["entry_names"], told["entry_values"]
    return {
        frozenset((names[row], names[column])): bool(values[row][column])
        for row, column in combinations(range(len(names)), 2)
    }


if __name__ == "__main__":
    main()
