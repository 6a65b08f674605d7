"""Kinds of seeds, each with what it is."""

from enum import Enum


class SeedKind(Enum):
    """Where a seed comes from; each value says so in words."""

    STRAIGHT = "the straight line to the nearest goal configuration"
    BRANCH = "the straight line to another goal configuration"
    FREE_END = "the straight line, with the goal configuration free to change"
    AROUND = "the line bent around what blocked an earlier attempt"
    BUMP = "the line bent to a random side"
    GIVEN = "a path that was given or remembered"
    RUNNING = "what is left of the running motion"
    SAMPLED = "the path of a sampling planner, shortened"
