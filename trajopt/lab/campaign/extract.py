"""Single rows of a campaign: its problem, its motion, or a bundle; and experience from all."""

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
"""Columns of a motion."""


@dataclass(frozen=True)
class Extracted:
    """A row written as a bundle.

    Attributes:
        path: The bundle.
        row: The row's id.
        same: Whether planning again returned the row's motion, or its status without one; None if
            nothing was planned.
    """

    path: Path
    row: str
    same: bool | None


@checked
def problem_of(folder: CampaignFolder, row_id: str, *, meshes: Path | str | None = None) -> Problem:
    """Return the problem of a row.

    Args:
        folder: The campaign.
        row_id: The row's id, or a prefix of it.
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
        folder: The campaign.
        row_id: The row's id, or a prefix of it.
        path: The bundle, by convention with the suffix ".trajopt". Meshes are unpacked beside it.

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
    """Return the motion of a row, or None.

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
    """Return whether two motions are equal to the last digit; an unverified one counts as none."""
    if a is None or b is None:
        return a is None
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in MOTIONS[1:])


@checked
def remember(folder: CampaignFolder, experience: Experience) -> int:
    """Store the verified motions of a campaign as experience, in the campaign's order, until it is full.

    Problems close to a stored one are skipped.

    Args:
        folder: The campaign.
        experience: The experience; that of a warehouse, `Warehouse.experience()`, is stored permanently.

    Returns:
        The number of new memories.

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
