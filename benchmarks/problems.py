"""Problems that grow in one direction at a time: knots, boxes, faces of a mesh, joints."""

from dataclasses import replace
from pathlib import Path

import numpy as np

import trajopt as to
from trajopt.geometry import Query
from trajopt.values.arrays import Floats
from trajopt.values.shapes.mesh import Mesh

START = {
    "panda_joint1": -0.8, "panda_joint2": 0.3, "panda_joint3": 0.0, "panda_joint4": -2.0,
    "panda_joint5": 0.0, "panda_joint6": 2.3, "panda_joint7": 0.8,
}  # fmt: skip
GOAL = {**START, "panda_joint1": 0.8, "panda_joint2": 0.5, "panda_joint4": -1.8}
FREE_SPACE = 0.15
"""Further boxes keep this far from the way that the arm takes without them [m]."""
CLOSE_BY = (0.03, 0.15)
"""Boxes close by come nearer to that way than the one and no nearer than the other [m]."""
BOX = to.Box(0.08, 0.06, 0.1)
CRUMB = to.Box(0.03, 0.02, 0.04)


def past_pillar(robot: to.Robot, *, knots: int = 24, boxes: int = 2) -> to.Problem:
    """A Panda swings around a pillar on a table, among further boxes that leave its way free.

    Args:
        robot: The Panda.
        knots: Knots of the path.
        boxes: Obstacles in all; the first two are the table and the pillar.
    """
    scene = (
        to.Scene(robot)
        .add("table", to.Box(1.2, 1.6, 0.04), to.placement((0.5, 0.0, -0.06)))
        .add("pillar", to.Box(0.08, 0.08, 0.5), to.placement((0.55, 0.0, 0.2)))
    )
    problem = to.Problem(
        scene=scene, group="panda_arm", start=START, goal=to.joint_positions(GOAL), knots=knots
    )
    if boxes <= 2:
        return problem
    places = _places_beside(problem, BOX, boxes - 2, FREE_SPACE, np.inf)
    return _among(problem, BOX, places)


def close_by(robot: to.Robot, boxes: int) -> to.Problem:
    """The same swing among small boxes that all lie close to its way.

    Args:
        robot: The Panda.
        boxes: Small boxes beside the table and the pillar.
    """
    problem = past_pillar(robot)
    return _among(problem, CRUMB, _places_beside(problem, CRUMB, boxes, *CLOSE_BY))


def carrying(robot: to.Robot, things: int) -> to.Problem:
    """The same swing with small boxes in the hand, in rows beyond the fingers.

    Args:
        robot: The Panda.
        things: Boxes that it carries.
    """
    problem = past_pillar(robot)
    scene, touched = problem.scene, ["panda_hand", "panda_leftfinger", "panda_rightfinger"]
    for count in range(things):
        row, column = divmod(count, 10)
        where = to.placement((0.012 * (row - 4.5), 0.012 * (column - 4.5), 0.12))
        scene = scene.add(
            f"thing{count}", to.Box(0.01, 0.01, 0.02), where, frame="panda_hand", touch_links=touched
        )
    return replace(problem, scene=scene)


def _among(problem: to.Problem, shape: to.Box, places: list[to.Placement]) -> to.Problem:
    scene = problem.scene
    for count, where in enumerate(places):
        scene = scene.add(f"box{count}", shape, where)
    return replace(problem, scene=scene)


def _between(first: Floats, last: Floats) -> Floats:
    return np.linspace(first, last, 6)


def _places_beside(
    problem: to.Problem, shape: to.Box, count: int, nearest: float, farthest: float
) -> list[to.Placement]:
    """Draw places between two distances from the way that the arm takes, the same ones in every run."""
    path = to.plan(problem).require().path
    way = np.concatenate([_between(*ends) for ends in zip(path.knots, path.knots[1:], strict=False)])
    rng = np.random.default_rng(0)
    low, high = (
        ((-2.5, -2.5, -0.5), (2.5, 2.5, 2.5)) if np.isinf(farthest) else ((-0.3, -0.8, 0.0), (0.8, 0.8, 1.1))
    )
    places: list[to.Placement] = []
    while len(places) < count:
        batch = [to.placement(rng.uniform(low, high), rpy=rng.uniform(-3.0, 3.0, 3)) for _ in range(200)]
        trial = to.Scene(problem.scene.robot)
        for index, where in enumerate(batch):
            trial = trial.add(f"trial{index}", shape, where)
        reduced = replace(problem, scene=trial).reduced
        apart: dict[str, float] = {}
        reach = nearest if np.isinf(farthest) else farthest
        found = Query(reduced).close_pairs(way, np.full(len(reduced.pairs.margin), reach))
        for pair, distance in zip(found.pair.tolist(), found.distance.tolist(), strict=True):
            for name in reduced.owners(pair):
                apart[name] = min(apart.get(name, np.inf), distance)
        places.extend(
            where
            for index, where in enumerate(batch)
            if nearest <= apart.get(f"trial{index}", np.inf) <= farthest
        )
    return places[:count]


def over_waves(robot: to.Robot, faces: int) -> to.Problem:
    """A Panda swings close over a rippled sheet, one exact triangle mesh, around a pillar.

    Args:
        robot: The Panda.
        faces: Triangles of the sheet, about; its form is the same whatever their number.
    """
    side = max(int(np.sqrt(faces / 2)), 2)
    x, y = np.meshgrid(np.linspace(0.2, 1.0, side + 1), np.linspace(-0.8, 0.8, side + 1), indexing="ij")
    z = 0.02 * np.sin(14.0 * x) * np.sin(11.0 * y) + 0.13
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    right, up = corner + side + 1, corner + 1
    triangles = np.concatenate(
        (np.stack((corner, right, up), axis=1), np.stack((right, right + 1, up), axis=1))
    )
    sheet = Mesh(np.stack((x, y, z), axis=2).reshape(-1, 3), triangles.astype(np.int32))
    scene = (
        to.Scene(robot)
        .add("sheet", sheet, to.placement())
        .add("pillar", to.Box(0.08, 0.08, 0.5), to.placement((0.55, 0.0, 0.25)))
    )
    return to.Problem(scene=scene, group="panda_arm", start=START, goal=to.joint_positions(GOAL))


def arms(folder: Path, joints: int) -> to.Problem:
    """One arm of up to seven joints, or two arms of half as many each, past a post.

    Args:
        folder: Where the description is written.
        joints: Joints in all, 2 to 14; even beyond seven.
    """
    sides = [("one", 0.0, joints)] if joints <= 7 else [("one", -0.5, joints // 2), ("two", 0.5, joints // 2)]
    text = '<robot name="arms"><link name="base"/>' + "".join(_arm(*side) for side in sides) + "</robot>"
    path = folder / f"arms{joints}.urdf"
    path.write_text(text)
    robot = to.Robot.from_urdf(path)
    scene = to.Scene(robot)
    for name, y, _ in sides:
        scene = scene.add(f"post_{name}", to.Cylinder(0.05, 0.2), to.placement((0.55, y, 0.0)))
    first = [name for name in robot.joint_names if name.endswith("_0")]
    start = {name: -0.9 if name in first else 0.05 for name in robot.joint_names}
    goal = {name: 0.9 if name in first else 0.1 for name in robot.joint_names}
    return to.Problem(scene=scene, start=start, goal=to.joint_positions(goal))


def _arm(name: str, y: float, joints: int) -> str:
    length = 1.0 / joints
    parts: list[str] = []
    parent, origin = "base", f'<origin xyz="0 {y} 0"/>'
    for index in range(joints):
        link, axis = f"{name}_link{index}", "0 0 1" if index % 2 == 0 else "0 1 0"
        parts.append(
            f'<link name="{link}"><collision><origin xyz="{length / 2} 0 0"/><geometry>'
            f'<box size="{0.8 * length} 0.05 0.05"/></geometry></collision></link>'
            f'<joint name="{name}_{index}" type="revolute"><parent link="{parent}"/><child link="{link}"/>'
            f'{origin}<axis xyz="{axis}"/><limit lower="-2.8" upper="2.8" effort="50" velocity="2"/></joint>'
        )
        parent, origin = link, f'<origin xyz="{length} 0 0"/>'
    return "".join(parts)
