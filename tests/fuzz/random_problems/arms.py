"""Arms of the random problems: planar ones, random ones, ones with chains of mimics, and installed ones."""

from functools import cache
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import trajopt_robots
from trajopt_robots._example_robot_data import share_folder

from tests.fuzz.dense_check import FILES
from tests.fuzz.random_problems.case import Arm, Source
from tests.fuzz.random_problems.chain import read_chain
from tests.fuzz.random_problems.shapes import Body, box, cylinder, sphere

INSTALLED = {
    "panda": ("panda_arm", "panda_hand", {"panda_finger_joint1": 0.02, "panda_finger_joint2": 0.02}),
    "ur5": ("manipulator", "tool0", {}),
    "xarm7": ("xarm7", "link_eef", {}),
}
"""Group, link at the tip, and where the joints stand that the group does not move."""


@cache
def installed(name: str) -> Arm:
    """Return an installed robot, read anew from its files."""
    urdf, srdf = FILES[name]
    share, folder = Path(share_folder()), Path(trajopt_robots.__file__).parent
    group, tip, still = INSTALLED[name]
    source = Source(name)
    chain = read_chain(
        (share / urdf).read_text(),
        driven=source.robot().group(group).joints,
        srdf=(folder / srdf).read_text(),
        limits=(folder / name / "joint_limits.yaml").read_text(),
        still=still,
        packages=share,
    )
    return Arm(source, group, chain, tip)


def planar(rng: np.random.Generator, links: int | None = None) -> Arm:
    """Return an arm of a few links in a plane, all joints upright."""
    count = links or int(rng.integers(2, 5))
    text, limits, length = [_link("base", box(0.06, 0.06, 0.06), (0, 0, 0))], [], 0.0
    for number in range(1, count + 1):
        at = "0 0 0.1" if number == 1 else f"{length:.4f} 0 0"
        length = float(rng.uniform(0.2, 0.4))
        turn = float(rng.uniform(1.5, 3.0))
        text.append(_link(f"link{number}", box(0.8 * length, 0.04, 0.04), (length / 2.0, 0, 0)))
        text.append(_joint(number, "revolute", at, "0 0 1", -turn, turn, float(rng.uniform(1, 3))))
        limits.append((f"joint{number}", float(rng.uniform(2, 10))))
    return _arm(text, limits, f"link{count}")


def random_arm(rng: np.random.Generator, *, mimics: bool = False, tight: bool = False) -> Arm:
    """Return an arm with joints of all kinds about odd axes.

    Args:
        rng: Draws it.
        mimics: Whether some joints follow others, one following the other in chains.
        tight: Whether the limits of the followers are narrower than those of what they follow.
    """
    count = int(rng.integers(5, 9)) if mimics else int(rng.integers(3, 6))
    text, limits = [_link("base", box(0.08, 0.08, 0.06), (0, 0, -0.02))], list[tuple[str, float]]()
    length, ranges, chained = 0.0, dict[int, tuple[float, float, str]](), 0
    for number in range(1, count + 1):
        kind = str(rng.choice(["revolute", "prismatic", "continuous"], p=[0.75, 0.15, 0.1]))
        at = "0 0 0.08" if number == 1 else f"{length:.4f} 0 0"
        source = _source(rng, number, ranges, chained) if mimics and number > 1 else 0
        chained = chained + 1 if source else 0
        axis = " ".join(f"{part:.3f}" for part in rng.normal(size=3))
        length = float(rng.uniform(0.12, 0.28))
        text.append(_link(f"link{number}", limb(rng, length), (length / 2.0, 0, 0)))
        kind = ranges[source][2] if source else kind
        low, high = (-0.05, float(rng.uniform(0.08, 0.2))) if kind == "prismatic" else turns(rng)
        mimic = ""
        if source:
            kind = "revolute" if kind == "continuous" else kind
            low, high, mimic = following(rng, f"joint{source}", ranges[source], tight)
        speed = float(rng.uniform(0.3, 2.5))
        text.append(_joint(number, kind, at, axis, low, high, speed, mimic))
        limits.append((f"joint{number}", float(rng.uniform(1, 10))))
        ranges[number] = (low, high, kind)
    return _arm(text, limits, f"link{count}")


def _source(
    rng: np.random.Generator, number: int, ranges: dict[int, tuple[float, float, str]], chained: int
) -> int:
    """Return which joint a new one follows; 0 for none. Chains grow to three followers."""
    if chained and chained < 3 and rng.random() < 0.6:
        return number - 1
    if rng.random() < 0.5:
        return 0
    return int(rng.choice([place for place in ranges]))


def following(
    rng: np.random.Generator, leader: str, range_of: tuple[float, float, str], tight: bool
) -> tuple[float, float, str]:
    """Return limits of a follower and its element; `range_of`: lowest, highest and kind of its leader."""
    factor = float(rng.choice([-1, 1])) * float(rng.uniform(0.3, 1.5))
    offset = float(rng.uniform(-0.2, 0.2)) * (0.1 if range_of[2] == "prismatic" else 1.0)
    if rng.random() < 0.3:
        offset = 0.0
    ends = sorted((factor * range_of[0] + offset, factor * range_of[1] + offset))
    wide = ends[1] - ends[0]
    share = float(rng.uniform(0.1, 0.3)) if tight else -0.01
    low, high = ends[0] + share * wide, ends[1] - share * wide
    return low, high, f'<mimic joint={quoteattr(leader)} multiplier="{factor!r}" offset="{offset!r}"/>'


def turns(rng: np.random.Generator) -> tuple[float, float]:
    """Return limits of a joint that turns [rad]."""
    return -float(rng.uniform(0.8, 2.8)), float(rng.uniform(0.8, 2.8))


def limb(rng: np.random.Generator, length: float) -> Body:
    """Return a body for a link of a length [m]."""
    thick = float(rng.uniform(0.02, 0.04))
    return [box(0.6 * length, thick, thick), cylinder(0.5 * thick, 0.6 * length), sphere(0.3 * length)][
        int(rng.choice(3, p=[0.6, 0.2, 0.2]))
    ]


def _link(name: str, body: Body, at: tuple[float, float, float]) -> str:
    lying = ' rpy="0 1.5707963267948966 0"' if body.kind == "cylinder" else ""
    where = " ".join(f"{part:.6f}" for part in at)
    return (
        f'<link name="{name}"><collision><origin xyz="{where}"{lying}/><geometry>{body.urdf}</geometry>'
        "</collision></link>"
    )


def _joint(
    number: int, kind: str, at: str, axis: str, low: float, high: float, speed: float, mimic: str = ""
) -> str:
    parent = "base" if number == 1 else f"link{number - 1}"
    bounds = "" if kind == "continuous" else f'lower="{low!r}" upper="{high!r}" '
    return (
        f'<joint name="joint{number}" type="{kind}"><parent link="{parent}"/><child link="link{number}"/>'
        f'<origin xyz="{at}"/><axis xyz="{axis}"/><limit {bounds}effort="100" velocity="{speed!r}"/>{mimic}'
        "</joint>"
    )


def _arm(text: list[str], limits: list[tuple[str, float]], tip: str) -> Arm:
    urdf = '<robot name="arm">' + "".join(text) + "</robot>"
    stated = "joint_limits:\n" + "".join(
        f"  {name}:\n    has_acceleration_limits: true\n    max_acceleration: {most!r}\n"
        for name, most in limits
    )
    return Arm(Source("", urdf, "", stated), "all", read_chain(urdf, limits=stated), tip)
