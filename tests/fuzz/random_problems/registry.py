"""The families by name, and the order in which they are asked."""

from collections.abc import Callable, Iterator, Sequence
from itertools import cycle
from zlib import crc32

import numpy as np

from tests.fuzz.random_problems import families, families_apart, families_robots
from tests.fuzz.random_problems.case import Case

FAMILIES: dict[str, tuple[int, Callable[[np.random.Generator], Case]]] = {
    "joint_tolerance": (4, families.joint_tolerance),
    "two_goals": (3, families.two_goals),
    "near_start": (3, families.near_start),
    "mimic_chain": (4, families.mimic_chain),
    "mimic_limits": (3, families.mimic_limits),
    "clearance_of_all": (3, families.clearance_of_all),
    "clearance_of_pairs": (2, families.clearance_of_pairs),
    "clearance_of_kinds": (2, families.clearance_of_kinds),
    "margins": (2, families.margins),
    "walls": (3, families.walls),
    "open_meshes": (2, families_apart.open_meshes),
    "closed_meshes": (3, families_apart.closed_meshes),
    "meant_contact": (3, families_apart.meant_contact),
    "kept_requirements": (3, families_apart.kept_requirements),
    "conflicts": (4, families_apart.conflicts),
    "conflicts_panda": (1, families_apart.conflicts_panda),
    "clutter_panda": (1, families_apart.clutter("panda")),
    "clutter_ur5": (1, families_apart.clutter("ur5")),
    "clutter_xarm7": (1, families_apart.clutter("xarm7")),
    "serial_robots": (2, families_robots.robots()),
    "tree_robots": (2, families_robots.robots(tree=True)),
    "mimic_robots": (2, families_robots.robots(tree=True, mimics=True)),
}
"""Name -> how many of each round are of it, and what draws one."""


def case(family: str, seed: int) -> Case:
    """Return a problem; the same one for a family and seed on every machine."""
    rng = np.random.default_rng((20261122, crc32(family.encode()), seed))
    return FAMILIES[family][1](rng)


def keys(count: int, *, start: int = 0, families: Sequence[str] = ()) -> Iterator[tuple[str, int]]:
    """Return family and seed of problems in the order in which they are asked, each family from a seed on."""
    chosen = {name: FAMILIES[name][0] for name in (families or FAMILIES)}
    rounds = [name for turn in range(max(chosen.values())) for name in chosen if turn < chosen[name]]
    seeds = dict.fromkeys(chosen, start)
    for _, name in zip(range(count), cycle(rounds), strict=False):
        yield name, seeds[name]
        seeds[name] += 1
