"""Motions that are remembered: the most similar one is where planning begins."""

from trajopt.experience.experience import Experience as Experience
from trajopt.experience.memory import Memory as Memory
from trajopt.experience.storage import Storage as Storage
