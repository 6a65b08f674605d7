"""Arguments of the functions of campaigns that are right, by "function.argument"."""

from pathlib import Path
from typing import Any

import trajopt as to
from trajopt.lab.campaign import Campaign, CampaignFolder, random_motions

NOWHERE = Path("nothing")


def campaign_samples(problem: to.Problem) -> dict[str, Any]:
    """Return right arguments.

    Args:
        problem: What is planned.
    """
    source = random_motions(problem.scene, 1)
    return {
        "Options.method": "sqp",
        "compare_campaigns.first": object.__new__(CampaignFolder),
        "compare_campaigns.second": object.__new__(CampaignFolder),
        "Campaign.sources": [source],
        "Campaign.options": (),
        "CampaignFolder.begin.campaign": Campaign("x", [source]),
        "CampaignFolder.begin.path": NOWHERE,
        "CampaignFolder.open.path": NOWHERE,
        "CampaignFolder.rows.columns": ("id",),
        "from_folder.path": NOWHERE,
        "from_table.path": NOWHERE,
        "from_table.around": problem.scene,
        "extract.path": NOWHERE,
        "Dataset.write.path": NOWHERE,
        "Dataset.chosen.first": 0.0,
        "Dataset.chosen.last": 1.0,
        "Dataset.batches.size": 1,
        "motion_of.row": {},
        "read_dataset.path": NOWHERE,
        "from_problems.listed": [problem],
        "base_placements.tasks": [problem],
        "base_placements.x": (0.0,),
        "base_placements.y": (0.0,),
        "installed.name": "planar_fold",
        "perturbed.problem": problem,
        "run_campaign.campaign": Campaign("x", [source]),
    }
