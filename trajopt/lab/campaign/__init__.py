"""Campaigns: thousands to millions of plans, on one core, one machine or a cluster.

    from trajopt.lab.campaign import Campaign, random_motions, run_campaign
    run_campaign(Campaign("reach", [random_motions(scene, 10_000)]), "out/reach")

`CampaignFolder.open(folder).rows()` yields the results.
"""

from trajopt.lab.campaign.campaign import Campaign as Campaign
from trajopt.lab.campaign.campaign import Options as Options
from trajopt.lab.campaign.cluster import Ray as Ray
from trajopt.lab.campaign.dataset import Dataset as Dataset
from trajopt.lab.campaign.dataset import Extracted as Extracted
from trajopt.lab.campaign.dataset import dataset as dataset
from trajopt.lab.campaign.dataset import extract as extract
from trajopt.lab.campaign.dataset import motion_of as motion_of
from trajopt.lab.campaign.dataset import problem_of as problem_of
from trajopt.lab.campaign.dataset import read_dataset as read_dataset
from trajopt.lab.campaign.dataset import remember as remember
from trajopt.lab.campaign.engine import Engine as Engine
from trajopt.lab.campaign.kept import CampaignFolder as CampaignFolder
from trajopt.lab.campaign.row import Fate as Fate
from trajopt.lab.campaign.running import Progress as Progress
from trajopt.lab.campaign.running import resume_campaign as resume_campaign
from trajopt.lab.campaign.running import run_campaign as run_campaign
from trajopt.lab.campaign.sources import ProblemSource as ProblemSource
from trajopt.lab.campaign.sources import base_placements as base_placements
from trajopt.lab.campaign.sources import from_folder as from_folder
from trajopt.lab.campaign.sources import from_problems as from_problems
from trajopt.lab.campaign.sources import from_table as from_table
from trajopt.lab.campaign.sources import installed as installed
from trajopt.lab.campaign.sources import perturbed as perturbed
from trajopt.lab.campaign.sources import random_motions as random_motions
from trajopt.lab.campaign.summary import CampaignSummary as CampaignSummary
from trajopt.lab.campaign.summary import Comparison as Comparison
from trajopt.lab.campaign.summary import compare_campaigns as compare_campaigns
from trajopt.lab.campaign.summary import summary as summary
from trajopt.lab.campaign.supervisor import Local as Local
