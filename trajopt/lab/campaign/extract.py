"""Single rows of a campaign: the problem made again, the motion, a bundle that says all."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trajopt.lab.campaign.columns import Row
from trajopt.lab.campaign.documents import Library
from trajopt.lab.campaign.kept import CampaignFolder
from trajopt.lab.campaign.recipes import Workshop, read
from trajopt.lab.campaign.row import Fate
from trajopt.planning.experience import Experience
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Floats
from trajopt.values.errors import CampaignError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

MOTIONS = ("joint_names", "times", "positions", "velocities", "accelerations")
"""Columns that a motion is made of."""


@dataclass(frozen=True)
class Extracted:
    """A row written as a bundle.

    Attributes:
        path: The bundle.
        row: The row's id.
        same: Whether planning anew gave the motion of the row, or its status where it has none; None where
            there was nothing to plan anew.
    """

    path: Path
    row: str
    same: bool | None


@checked
def problem_of(folder: CampaignFolder, row_id: str, *, meshes: Path | str | None = None) -> Problem:
    """Return the problem of a row.

    Args:
        folder: The campaign.
        row_id: The row's id, or the beginning of it.
        meshes: A folder to unpack the meshes to that a viewer draws; without them when None.

    Raises:
        CampaignError: If there is no such row, or several.
        TrajoptError: What making the problem raises, where the row says `INVALID`.
    """
    shop = Workshop(Library(folder.documents, meshes=None if meshes is None else Path(meshes)))
    return read(folder.task(row_id).recipe).problem(shop)


@checked
def extract(folder: CampaignFolder, row_id: str, path: Path | str) -> Extracted:
    """Write a row as a bundle: the problem planned anew, as it was, or the problem alone where that crashes.

    Args:
        folder: The campaign.
        row_id: The row's id, or the beginning of it.
        path: The bundle, whose name ends in ".trajopt" by custom. Meshes are unpacked beside it.

    Raises:
        CampaignError: If there is no such row, or several, or the versions are not those that planned it.
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
    """Return the motion of a row; None where it has none.

    Args:
        row: A row of the results, with the columns of the motion.

    Raises:
        CampaignError: If the row was read without them.
    """
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
    """Say whether two motions are the same to the last digit; what is no verified motion is none."""
    if a is None or b is None:
        return a is None
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in MOTIONS[1:])


@checked
def remember(folder: CampaignFolder, experience: Experience) -> int:
    """Have experience remember the verified motions of a campaign, in the campaign's order, until it is full.

    A problem as near as one that is remembered adds nothing: its motion is left out.

    Args:
        folder: The campaign.
        experience: What remembers: that of a warehouse, `Warehouse.experience()`, stays.

    Returns:
        How many are remembered now that were not before.

    Raises:
        FileFormatError: If a document of the campaign, or the file of a warehouse, is damaged.
    """
    shop, count = Workshop(Library(folder.documents)), 0
    solved = _solved(folder)
    for task in folder.tasks():
        if len(experience) >= experience.most:
            break
        if task.id in solved:
            goal_name, points = solved[task.id]
            problem = read(task.recipe).problem(shop)
            alone = problem.alternatives[goal_name] if goal_name else problem
            count += experience.remember(alone, points)
    return count


def _solved(folder: CampaignFolder) -> dict[str, tuple[str, Floats]]:
    """Return the verified motions of a campaign by row, each with the goal of a set that it reached."""
    found: dict[str, tuple[str, Floats]] = {}
    for row in folder.rows(("verified", "goal_name", *MOTIONS)):
        motion = motion_of(row) if row["verified"] else None
        if motion is not None:
            found[row["id"]] = row["goal_name"], motion.positions
    return found
