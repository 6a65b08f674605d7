"""Motions that are remembered: the most similar one is where planning begins."""

from trajopt.planning.experience.experience import Experience as Experience
from trajopt.planning.experience.storage import Memory as Memory
from trajopt.planning.experience.storage import Storage as Storage
