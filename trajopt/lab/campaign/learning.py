"""Rows of a campaign as experience: its motions are where planning begins for problems much like its own."""

from trajopt.lab.campaign.documents import Library
from trajopt.lab.campaign.extract import MOTIONS, motion_of
from trajopt.lab.campaign.kept import CampaignFolder
from trajopt.lab.campaign.recipes import Workshop, read
from trajopt.planning.experience import Experience
from trajopt.values.arrays import Floats
from trajopt.values.errors.arguments import checked


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
