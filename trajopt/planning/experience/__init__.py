"""Remembered motions: planning begins with the most similar one."""

from trajopt.planning.experience.experience import Experience as Experience
from trajopt.planning.experience.experience import Memory as Memory
from trajopt.planning.experience.experience import Storage as Storage
