"""perceive(scene, image): a scene with what was measured, as one object that is replaced whole."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from trajopt.lab.perception.cells import MOST_CELLS_ACROSS, centres, once, packed, unpacked
from trajopt.lab.perception.cloud import Cloud
from trajopt.lab.perception.depth_image import DepthImage
from trajopt.lab.perception.point_cloud import PointCloud
from trajopt.lab.perception.robot_mask import RobotMask
from trajopt.lab.perception.sensing import DEFAULT, Sensing
from trajopt.lab.perception.sight import Sight
from trajopt.lab.perception.taken import Radius, Taken
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Ints, Value
from trajopt.values.errors import ProblemError, SizeError
from trajopt.values.errors.arguments import checked
from trajopt.values.printed import in_length
from trajopt.values.shapes.shapes import Voxels

Measured = DepthImage | PointCloud
"""What a sensor measured at one time."""
M = TypeVar("M", DepthImage, Measured)
MOST_CELLS = 1 << 24
"""Cells of a workspace that are looked at one by one, to find those that nobody saw: 256 to each side."""


@dataclass(frozen=True, eq=False)
class Perceived(Value):
    """What was made of measurements.

    Attributes:
        scene: With the cloud as one object.
        cloud: The cloud.
    """

    scene: Scene
    cloud: Cloud


@checked
def perceive(
    scene: Scene,
    measured: Measured | Sequence[Measured],
    sensing: Sensing = DEFAULT,
    *,
    name: str = "camera",
    before: Cloud | None = None,
) -> Perceived:
    """Put what was measured into a scene, in place of what an object of that name was.

    What is proven then is clearance from the measured points, each a ball of the cloud's radius; nothing is
    known of what was not seen. `with_unseen` makes that solid.

    Args:
        scene: The robot and what is known already.
        measured: One image or cloud, or several, of one camera or of more.
        sensing: How measurements become obstacles.
        name: Of the object.
        before: What was seen before, which stays where no image sees through it now; None to forget it.

    Returns:
        The scene with the cloud. Where nothing was seen, the object is a mere frame.

    Raises:
        FrameNotFound: If the scene has no such frame as a camera is fixed on.
        ObjectNotFound: If an object that is called known is not in the scene.
        ProblemError: If nothing is given, or what was seen before has cells of another size.
        ShapeError: If there is not one position for each joint of the robot.
    """
    each = _several(measured)
    known = _without(scene, name)
    taken = [item.taken(known, sensing) for item in each]
    found: list[Ints] = []
    robot = 0
    for one in taken:
        kept = _beside_robot(known, one.keys, one.positions, sensing)
        robot += len(one.keys) - len(kept)
        found.append(kept)
    radius, stays = _largest(taken), np.empty(0, dtype=np.int64)
    if before is not None:
        stays = _beside_robot(known, _hidden(known, before, each, sensing), each[-1].positions, sensing)
        radius = _larger(radius, before.radius) if len(stays) else radius
    keys = once(np.concatenate((*found, stays)))
    counts = {key: sum(one.counts[key] for one in taken) for key in taken[0].counts}
    counts |= {"cells taken for the robot": robot}
    counts |= {} if before is None else {"cells kept from before": len(stays)}
    cloud = Cloud(keys, sensing.cell, radius, counts)
    return Perceived(scene.with_cloud(name, cloud.shape), cloud)


@checked
def with_unseen(
    scene: Scene,
    images: DepthImage | Sequence[DepthImage],
    sensing: Sensing,
    *,
    cell: float = 0.02,
    name: str = "unseen",
) -> Scene:
    """Make solid all of the workspace that no image sees to be empty, as one object of cubes.

    A cube is empty if every pixel of an image that looks at any of it measured something behind it, the
    noise taken off; a pixel that measured nothing shows nothing. Where the robot was when an image was taken
    is not solid, nor what is as near to it as `sensing.padding`: else it could not move. That nothing else
    is there, nobody saw: certificates state it, with the number of cubes and how far they reach. Everything
    else in the workspace that has not moved since is kept clear of, as far as the camera's noise and
    placement are what they are said to be.

    Args:
        scene: The robot.
        images: One or several, of one camera or of more.
        sensing: Has the workspace.
        cell: Edge of the cubes [m].
        name: Of the object.

    Raises:
        ProblemError: If there is no workspace, or no image.
        SizeError: If the workspace has more than 2^24 such cubes.
        FrameNotFound: If the scene has no such frame as a camera is fixed on.
    """
    each = _several(images)
    known = _without(scene, name)
    keys = _grid(sensing, cell)
    middles, radius = centres(keys, cell), cell * np.sqrt(3.0) / 2.0
    hidden = np.ones(len(keys), dtype=np.bool_)
    for image in each:
        sight = Sight.of(image, known, sensing, holes_are_clear=False)
        hidden[hidden] = ~sight.through(middles[hidden], radius)
    unseen = np.flatnonzero(hidden)
    near, inside = np.zeros((2, len(unseen)), dtype=np.bool_)
    for image in each:
        mask = RobotMask.of(known, image.positions, sensing.known)
        near |= mask.covers(middles[unseen], sensing.padding + radius)
        inside |= mask.covers(middles[unseen], 0.0)
    hidden[unseen[near]] = False
    left = unpacked(keys[hidden])
    given = _free_beside_robot(int((near & ~inside).sum()), cell, sensing)
    return scene.with_cloud(name, Voxels(left, cell) if len(left) else None, given=given)


def _free_beside_robot(count: int, cell: float, sensing: Sensing) -> tuple[str, ...]:
    """State what is taken for free although nobody saw it."""
    if not count:
        return ()
    known = "".join(f" and {name}" for name in sensing.known)
    cubes, reach = f"{count} cubes of {in_length(cell)}", in_length(sensing.padding + cell * np.sqrt(3.0))
    return (
        f"nothing is in {cubes} that no image shows, up to {reach} from where the robot{known} was when it "
        "was measured",
    )


def _several(measured: M | Sequence[M]) -> tuple[M, ...]:
    each = tuple(measured) if isinstance(measured, Sequence) else (measured,)
    if not each:
        raise ProblemError("give at least one image or cloud")
    return each


def _without(scene: Scene, name: str) -> Scene:
    """Return the scene as if nothing had been seen yet: a camera is not fixed on what it saw."""
    return scene.remove(name) if name in scene.objects else scene


def _beside_robot(scene: Scene, keys: Ints, positions: Floats, sensing: Sensing) -> Ints:
    """Return the cells that are neither the robot nor what is known."""
    mask = RobotMask.of(scene, positions, sensing.known)
    return keys[~mask.covers(centres(keys, sensing.cell), sensing.padding)]


def _hidden(scene: Scene, before: Cloud, now: Sequence[Measured], sensing: Sensing) -> Ints:
    """Return the cells of what was seen before that no image sees through now."""
    if before.cell != sensing.cell:
        raise ProblemError(
            f"before: has cells of {before.cell:g} m, the others of {sensing.cell:g} m: use one size for both"
        )
    keys = before.keys
    for image in now:
        if isinstance(image, DepthImage):
            sight = Sight.of(image, scene, sensing, holes_are_clear=True)
            keys = keys[~sight.through(centres(keys, before.cell), before.radius.whole)]
    return keys


def _grid(sensing: Sensing, cell: float) -> Ints:
    """Return all cells of the workspace, those at its border too."""
    if sensing.workspace is None:
        raise ProblemError("sensing: needs a workspace, which says how far there is anything unseen")
    begin = np.floor(sensing.workspace.lower / cell + 1e-9).astype(np.int64)
    end = np.ceil(sensing.workspace.upper / cell - 1e-9).astype(np.int64)
    many = float(np.prod((end - begin).astype(np.float64)))
    if many > MOST_CELLS or max(np.abs(begin).max(), np.abs(end).max()) >= MOST_CELLS_ACROSS:
        raise SizeError(
            "cell", f"of {cell:g} m makes {many:.3g} cubes of the workspace; {MOST_CELLS} are the most"
        )
    cells = np.indices((end - begin).tolist()).reshape(3, -1).T
    return packed(cells + begin)


def _largest(taken: Sequence[Taken]) -> Radius:
    radius = taken[0].radius
    for each in taken[1:]:
        radius = _larger(radius, each.radius)
    return radius


def _larger(a: Radius, b: Radius) -> Radius:
    return Radius(max(a.cell, b.cell), max(a.noise, b.noise), max(a.gap, b.gap))
