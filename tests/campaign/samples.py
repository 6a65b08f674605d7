"""Arguments of the functions of campaigns that are right, by "function.argument"."""

from pathlib import Path
from typing import Any

import trajopt as to
from trajopt.campaign import Campaign, random_motions

NOWHERE = Path("nothing")


def campaign_samples(problem: to.Problem) -> dict[str, Any]:
    """Return right arguments.

    Args:
        problem: What is planned.
    """
    source = random_motions(problem.scene, 1)
    return {
        "Options.method": "sqp",
        "Campaign.sources": [source],
        "Campaign.options": (),
        "CampaignFolder.begin.campaign": Campaign("x", [source]),
        "CampaignFolder.begin.path": NOWHERE,
        "CampaignFolder.open.path": NOWHERE,
        "CampaignFolder.rows.columns": ("id",),
        "from_folder.path": NOWHERE,
        "from_problems.listed": [problem],
        "base_placements.tasks": [problem],
        "base_placements.x": (0.0,),
        "base_placements.y": (0.0,),
        "installed.name": "planar_fold",
        "perturbed.problem": problem,
        "run_campaign.campaign": Campaign("x", [source]),
    }
