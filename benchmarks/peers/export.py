"""The problems and the robot as plain files, so that every planner meets the same geometry and limits."""

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

import trajopt as to
from trajopt.lab.suite import Instance
from trajopt.problem.requirements import JointPositions
from trajopt.scene.reduced import ReducedModel
from trajopt.values.documents.document import write_json
from trajopt.values.shapes.shapes import Convex, Shape
from trajopt.verify import Judge, Moment

DRAKE = "http://drake.mit.edu"
TESSERACT = "http://ros.org/wiki/tesseract"


@dataclass(frozen=True)
class Asked:
    """A problem that can be solved: its start and its goal are clear and inside the limits.

    Attributes:
        instance: Where it comes from.
        problem: The problem.
        goal: Joint positions of the goal, shape (n,) [rad].
    """

    instance: Instance
    problem: to.Problem
    goal: np.ndarray


def read_asked(instances: Sequence[Instance]) -> list[Asked]:
    """Read the answerable problems."""
    asked: list[Asked] = []
    for instance in instances:
        problem = instance.make()
        (goal,) = problem.goals
        if not isinstance(goal, JointPositions) or problem.constraints:
            raise ValueError(f"{instance.name}: only goals of joint positions can be compared")
        reduced = problem.reduced
        target = np.array([goal.positions[name] for name in reduced.joint_names])
        judge = Judge(reduced)
        ends = ((reduced.start_positions, Moment.START), (target, Moment.END))
        if all(judge.examine(positions, moment=moment).clear for positions, moment in ends):
            asked.append(Asked(instance, problem, target))
    return asked


def write_problems(folder: Path, asked: Sequence[Asked], *, time_limit: float) -> Path:
    """Write robot and problems below a folder; return the file that describes both."""
    first = asked[0].problem
    checked = _checked_links(first.reduced)
    for item in asked:
        same = item.problem.group == first.group and _checked_links(item.problem.reduced) == checked
        if not same or not np.array_equal(_locked(item.problem), _locked(first)):
            raise ValueError(f"{item.instance.name}: needs another robot model than the first problem")
    folder.mkdir(parents=True, exist_ok=True)
    _write_urdf(folder, first)
    _write_srdf(folder, first, checked)
    limits = first.limits
    entries = {
        name: {"max_acceleration": [float(limit)]}
        for name, limit in zip(limits.joint_names, limits.acceleration, strict=True)
    }
    (folder / "roboplan_limits.yaml").write_text(yaml.safe_dump({"joint_limits": entries}))
    document: dict[str, object] = {
        "time_limit": time_limit,
        "robot": {
            "name": first.scene.robot.name,
            "folder": str(folder.resolve()),
            "group": first.group,
            "joints": list(limits.joint_names),
            "lower": limits.lower.tolist(),
            "upper": limits.upper.tolist(),
            "velocity": limits.velocity.tolist(),
            "acceleration": limits.acceleration.tolist(),
            "checked_links": [list(pair) for pair in checked],
            "static_links": sorted(_static_links(first.reduced)),
        },
        "problems": [_problem(item) for item in asked],
    }
    write_json(folder / "problems.json", document)
    return folder / "problems.json"


def _locked(problem: to.Problem) -> np.ndarray:
    """Return the start positions of all joints outside the group."""
    outside = np.ones(len(problem.start_positions), dtype=bool)
    outside[problem.scene.robot.index(problem.reduced.joint_names)] = False
    return problem.start_positions[outside]


def _static_links(reduced: ReducedModel) -> frozenset[str]:
    links = reduced.scene.robot.links
    return frozenset(body.owner for body in reduced.bodies if body.joint == 0 and body.owner in links)


def _checked_links(reduced: ReducedModel) -> list[tuple[str, str]]:
    """Return the pairs of links that must keep apart; every moving link must from every object."""
    links = frozenset(reduced.scene.robot.links)
    owners = {reduced.owners(pair) for pair in range(len(reduced.pairs.first))}
    moving = {body.owner for body in reduced.bodies if body.owner in links} - _static_links(reduced)
    with_objects = {frozenset(pair) for pair in owners if not links.issuperset(pair)}
    if with_objects != {frozenset((link, name)) for link in moving for name in reduced.scene.objects}:
        raise ValueError("only scenes whose objects may touch no link can be compared")
    return sorted((min(pair), max(pair)) for pair in owners if links.issuperset(pair))


def _problem(asked: Asked) -> dict[str, object]:
    objects: list[dict[str, object]] = []
    for body in asked.problem.scene.object_bodies():
        kind, size = _primitive(body.shape)
        placement = body.placement.homogeneous.tolist()
        objects.append({"name": body.name, "kind": kind, "size": size, "placement": placement})
    name, number = asked.instance.name.split("/")
    scene, request = asked.instance.files
    return {
        "set": name,
        "index": int(number),
        "scene": str(scene.resolve()),
        "request": str(request.resolve()),
        "seed": int(number),
        "start": asked.problem.reduced.start_positions.tolist(),
        "goal": asked.goal.tolist(),
        "objects": objects,
    }


def _primitive(shape: Shape) -> tuple[str, list[float]]:
    match shape:
        case to.Box():
            return "box", [shape.x, shape.y, shape.z]
        case to.Cylinder():
            return "cylinder", [shape.radius, shape.length]
        case to.Sphere():
            return "sphere", [shape.radius]
        case _:
            raise ValueError(f"{type(shape).__name__}: only boxes, cylinders and spheres can be compared")


def _write_urdf(folder: Path, problem: to.Problem) -> None:
    """Write the robot with the joints outside the group fixed and with convex collision bodies only."""
    robot = problem.scene.robot
    ET.register_namespace("drake", DRAKE)
    ET.register_namespace("tesseract", TESSERACT)
    root = ET.fromstring(robot.urdf_xml)
    root.set(f"{{{TESSERACT}}}make_convex", "true")
    for link in root.iter("link"):
        _keep(link, ())
    for joint in root.iter("joint"):
        _keep(joint, ("origin", "parent", "child", "axis", "limit"))
        _limit_or_fix(joint, problem)
    links = {link.get("name"): link for link in root.iter("link")}
    for count, body in enumerate(robot.bodies):
        link = links[body.frame]
        collision = ET.SubElement(link, "collision", name=f"{body.frame}_{count}")
        _write_origin(collision, body.placement.rotation, body.placement.translation)
        geometry = ET.SubElement(collision, "geometry")
        if isinstance(body.shape, Convex):
            mesh = folder / f"hull_{count}.obj"
            _write_mesh(mesh, body.shape)
            element = ET.SubElement(geometry, "mesh", filename=str(mesh.resolve()))
            ET.SubElement(element, f"{{{DRAKE}}}declare_convex")
            checking = ET.SubElement(link, "collision_checking")
            ET.SubElement(checking, "convex", name=f"{body.frame}_{count}")
        else:
            kind, size = _primitive(body.shape)
            if kind != "box":
                raise ValueError(f"{body.name}: only hulls and boxes are written")
            ET.SubElement(geometry, "box", size=" ".join(map(repr, size)))
    ET.ElementTree(root).write(folder / "robot.urdf", xml_declaration=True, encoding="utf-8")


def _keep(element: ET.Element, tags: Sequence[str]) -> None:
    for child in list(element):
        if child.tag not in tags:
            element.remove(child)


def _limit_or_fix(joint: ET.Element, problem: to.Problem) -> None:
    """State trajopt's limits of a joint of the group; fix any other joint where it stands."""
    name, kind = joint.get("name", ""), joint.get("type", "")
    limits = problem.limits
    if name in limits.joint_names:
        place = limits.joint_names.index(name)
        element = joint.find("limit")
        assert element is not None
        for key in ("lower", "upper", "velocity"):
            element.set(key, repr(float(getattr(limits, key)[place])))
    elif kind != "fixed":
        robot = problem.scene.robot
        travel = problem.start_positions[robot.index([name])[0]] * _numbers(joint.find("axis"), "xyz")
        origin = joint.find("origin")
        rotation = Rotation.from_euler("xyz", _numbers(origin, "rpy"))
        translation = _numbers(origin, "xyz")
        if kind == "prismatic":
            translation = translation + rotation.apply(travel)
        else:
            rotation = rotation * Rotation.from_rotvec(travel)
        _keep(joint, ("parent", "child"))
        joint.set("type", "fixed")
        _write_origin(joint, rotation.as_matrix(), translation)


def _numbers(element: ET.Element | None, key: str) -> np.ndarray:
    text = "0 0 0" if element is None else element.get(key, "0 0 0")
    return np.array([float(word) for word in text.split()])


def _write_origin(parent: ET.Element, rotation: np.ndarray, translation: np.ndarray) -> None:
    angles = Rotation.from_matrix(rotation).as_euler("xyz")
    xyz, rpy = (" ".join(repr(float(x)) for x in row) for row in (translation, angles))
    ET.SubElement(parent, "origin", xyz=xyz, rpy=rpy)


def _write_mesh(path: Path, hull: Convex) -> None:
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in hull.vertices.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in hull.faces.tolist()]
    path.write_text("\n".join(lines) + "\n")


def _write_srdf(folder: Path, problem: to.Problem, checked: Sequence[tuple[str, str]]) -> None:
    """Write the group, and every pair of links that is not checked as disabled."""
    robot = problem.scene.robot
    root = ET.Element("robot", name=robot.name)
    group = ET.SubElement(root, "group", name=problem.group)
    for name in problem.reduced.joint_names:
        ET.SubElement(group, "joint", name=name)
    for pair in combinations(sorted(robot.links), 2):
        if pair not in checked:
            ET.SubElement(root, "disable_collisions", link1=pair[0], link2=pair[1], reason="Never")
    ET.ElementTree(root).write(folder / "robot.srdf", xml_declaration=True, encoding="utf-8")
