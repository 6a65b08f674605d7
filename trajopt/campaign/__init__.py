"""Campaigns: plans by the thousand and the million, on one core, on all, on a cluster.

    from trajopt.campaign import Campaign, random_motions, run_campaign
    run_campaign(Campaign("reach", [random_motions(scene, 10_000)]), "out/reach")

What is interrupted goes on with `resume_campaign`; `CampaignFolder.open(folder).rows()` yields the results.
"""

from trajopt.campaign.campaign import Campaign as Campaign
from trajopt.campaign.cluster import Ray as Ray
from trajopt.campaign.comparison import Comparison as Comparison
from trajopt.campaign.comparison import compare_campaigns as compare_campaigns
from trajopt.campaign.dataset import Dataset as Dataset
from trajopt.campaign.dataset import dataset as dataset
from trajopt.campaign.dataset import read_dataset as read_dataset
from trajopt.campaign.engine import Engine as Engine
from trajopt.campaign.extract import Extracted as Extracted
from trajopt.campaign.extract import extract as extract
from trajopt.campaign.extract import motion_of as motion_of
from trajopt.campaign.extract import problem_of as problem_of
from trajopt.campaign.kept import CampaignFolder as CampaignFolder
from trajopt.campaign.learning import remember as remember
from trajopt.campaign.local import Local as Local
from trajopt.campaign.options import Options as Options
from trajopt.campaign.row import Fate as Fate
from trajopt.campaign.running import Progress as Progress
from trajopt.campaign.running import resume_campaign as resume_campaign
from trajopt.campaign.running import run_campaign as run_campaign
from trajopt.campaign.sources import Source as Source
from trajopt.campaign.sources import base_placements as base_placements
from trajopt.campaign.sources import from_folder as from_folder
from trajopt.campaign.sources import from_problems as from_problems
from trajopt.campaign.sources import from_table as from_table
from trajopt.campaign.sources import installed as installed
from trajopt.campaign.sources import perturbed as perturbed
from trajopt.campaign.sources import random_motions as random_motions
from trajopt.campaign.summary import Summary as Summary
from trajopt.campaign.summary import summary as summary
