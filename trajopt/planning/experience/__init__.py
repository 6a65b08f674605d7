"""Remembered motions: planning begins with the most similar one."""

from trajopt.planning.experience.experience import Experience as Experience
from trajopt.planning.experience.storage import Memory as Memory
from trajopt.planning.experience.storage import Storage as Storage
