"""Reach maps and tables of configurations."""

from trajopt.lab.reach.reach_map import ReachMap as ReachMap
from trajopt.lab.reach.reach_map import reach_map as reach_map
from trajopt.lab.reach.table import ConfigurationTable as ConfigurationTable
from trajopt.lab.reach.table import read_table as read_table
from trajopt.lab.reach.table import sample_table as sample_table
