"""Verified motions of a campaign, extracted as bundles, as experience and as arrays for training."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trajopt.lab.campaign.columns import Row
from trajopt.lab.campaign.kept import CampaignFolder
from trajopt.lab.campaign.recipes import Library, Workshop, read
from trajopt.lab.campaign.row import Fate
from trajopt.planning.experience import Experience
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Floats, Value, readonly
from trajopt.values.documents.files import written_whole
from trajopt.values.errors import CampaignError, FileFormatError, ShapeError, shown
from trajopt.values.errors.arguments import checked, checked_class
from trajopt.values.trajectory import Trajectory

SHARES = 2**32
"""Beginnings of ids by which rows are shared out: evenly, for ids are hashes."""


@checked_class
@dataclass(frozen=True, eq=False)
class Dataset(Value):
    """Verified motions, each at the same number of points, evenly spaced in time.

    Attributes:
        ids: Of the rows, shape (N,).
        families: Sets of the problems, shape (N,).
        positions: Shape (N, T, n) [rad | m]; the start is the first point, the goal the last.
        velocities: Shape (N, T, n) [rad/s | m/s].
        clearances: Smallest proven clearance, NaN without pairs, shape (N,) [m].
    """

    joint_names: tuple[str, ...]
    ids: NDArray[np.str_]
    problem_ids: NDArray[np.str_]
    families: NDArray[np.str_]
    positions: Floats
    velocities: Floats
    durations: Floats
    clearances: Floats

    def __len__(self) -> int:
        return len(self.ids)

    def chosen(self, first: float, last: float) -> "Dataset":
        """Return the motions of a share of the problems, within [0, 1]: 0 to 0.8 to train, 0.8 to 1 to test.

        A problem is always on the same side, on every machine and in every campaign.

        Raises:
            ShapeError: If the ends do not increase within [0, 1].
        """
        if not 0.0 <= first < last <= 1.0:
            raise ShapeError("first, last", f"must increase within [0, 1], are {first:g} and {last:g}")
        place = np.array([int(key[:8], 16) / SHARES for key in self.problem_ids.tolist()])
        return self._rows((place >= first) & (place < last))

    def batches(self, size: int, *, rng: np.random.Generator) -> Iterator["Dataset"]:
        """Yield all motions once in random order, in batches of a size; the last batch may be smaller."""
        if size < 1:
            raise ShapeError("size", f"must be positive, is {size}")
        order = rng.permutation(len(self))
        return (self._rows(order[begin : begin + size]) for begin in range(0, len(order), size))

    def write(self, path: Path | str) -> None:
        """Write the arrays, named as the attributes, to a file that ends in `.npz`."""
        if Path(path).suffix != ".npz":
            raise FileFormatError(str(path), "a data set is written as .npz")
        with written_whole(path) as draft, draft.open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, **vars(self))

    def _rows(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> "Dataset":
        names = [name for name in vars(self) if name != "joint_names"]
        return replace(self, **{name: getattr(self, name)[which] for name in names})


@checked
def dataset(folder: CampaignFolder, points: int = 64) -> Dataset:
    """Return the verified motions of a campaign, ordered by id; all must have the same joints."""
    if points < 2:
        raise ShapeError("points", f"must be at least 2, is {points}")
    found: list[tuple[str, str, str, Floats, Floats, float, float]] = []
    joints: set[tuple[str, ...]] = set()
    for row in folder.rows(("problem_id", "family", "verified", "clearance", *MOTIONS)):
        motion = motion_of(row) if row["verified"] else None
        if motion is None:
            continue
        joints.add(motion.joint_names)
        if len(joints) > 1:
            raise CampaignError(f"{folder.path} has motions of different joints: {sorted(joints)}")
        times = np.linspace(0.0, motion.duration, points)
        near = np.nan if row["clearance"] is None else float(row["clearance"])
        keys = str(row["id"]), str(row["problem_id"]), str(row["family"])
        found.append((*keys, motion(times), motion(times, 1), motion.duration, near))
    if not found:
        raise CampaignError(f"{folder.path} has no verified motion")
    columns = zip(*sorted(found, key=lambda each: each[0]), strict=True)
    ids, problems, families, positions, velocities, durations, clearances = map(np.array, columns)
    motions = readonly(positions), readonly(velocities)
    return Dataset(next(iter(joints)), ids, problems, families, *motions, durations, clearances)


@checked
def read_dataset(path: Path | str) -> Dataset:
    """Read a file written by `Dataset.write`."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in Dataset.__dataclass_fields__ if name != "joint_names"}
            return Dataset(tuple(file["joint_names"].tolist()), **arrays)
    except (OSError, ValueError, KeyError, EOFError) as error:
        raise FileFormatError(str(path), f"holds no data set: {error}") from error


MOTIONS = ("joint_names", "times", "positions", "velocities", "accelerations")


@dataclass(frozen=True)
class Extracted:
    """A row written as a bundle; `same` is whether planning again agreed, None if nothing was planned."""

    path: Path
    row: str
    same: bool | None


@checked
def problem_of(folder: CampaignFolder, row_id: str, *, meshes: Path | str | None = None) -> Problem:
    """Return the problem of a row.

    Args:
        meshes: A folder for unpacked meshes for a viewer; none if None.

    Raises:
        CampaignError: If there is no such row, or several.
        TrajoptError: The error of a problem whose status is `INVALID`.
    """
    shop = Workshop(Library(folder.documents, meshes=None if meshes is None else Path(meshes)))
    return read(folder.task(row_id).recipe).problem(shop)


@checked
def extract(folder: CampaignFolder, row_id: str, path: Path | str) -> Extracted:
    """Write a row as a bundle, after planning its problem again; the problem alone if planning crashed.

    Args:
        path: The bundle. Meshes are unpacked next to it.

    Raises:
        CampaignError: If there is no such row, or several, or the package versions differ.
        FileFormatError: If the bundle cannot be written.
    """
    folder.check_versions()
    target, task = Path(path), folder.task(row_id)
    problem = problem_of(folder, task.id, meshes=target.with_name(f"{target.stem}_meshes"))
    row = next((each for each in folder.rows() if each["id"] == task.id), None)
    if row is not None and row["status"] in Fate.__members__:
        problem.save(target)
        return Extracted(target, task.id, None)
    result = folder.options[task.options].plan(problem, task.seed)
    result.save(target)
    same = (
        row is not None and result.status.name == row["status"] and _equal(motion_of(row), result.trajectory)
    )
    return Extracted(target, task.id, None if row is None else same)


@checked
def motion_of(row: Row) -> Trajectory | None:
    """Return the motion of a row, or None; the row needs the columns of the motion."""
    missing = [name for name in MOTIONS if name not in row]
    if missing:
        raise CampaignError(f"the row was read without its columns {', '.join(map(shown, missing))}")
    if not row["times"]:
        return None
    names = tuple(row["joint_names"])

    def points(name: str) -> Floats | None:
        return None if row[name] is None else np.reshape(row[name], (-1, len(names)))

    positions = points("positions")
    assert positions is not None
    return Trajectory(names, np.array(row["times"]), positions, points("velocities"), points("accelerations"))


def _equal(a: Trajectory | None, b: Trajectory | None) -> bool:
    if a is None or b is None:
        return a is None
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in MOTIONS[1:])


@checked
def remember(folder: CampaignFolder, experience: Experience) -> int:
    """Store a campaign's verified motions as experience until it is full; return the number of new ones.

    Problems close to a stored one are skipped.

    Raises:
        FileFormatError: If a document of the campaign, or the file of a warehouse, is damaged.
    """
    shop, count = Workshop(Library(folder.documents)), 0
    solved: dict[str, tuple[str, Floats]] = {}
    for row in folder.rows(("verified", "goal_name", *MOTIONS)):
        motion = motion_of(row) if row["verified"] else None
        if motion is not None:
            solved[row["id"]] = row["goal_name"], motion.positions
    for task in folder.tasks():
        if len(experience) >= experience.most:
            break
        if task.id in solved:
            goal_name, points = solved[task.id]
            problem = read(task.recipe).problem(shop)
            alone = problem.alternatives[goal_name] if goal_name else problem
            count += experience.remember(alone, points)
    return count
