"""Robots as nobody would draw them: arms and trees, odd names, meshes, links without mass."""

from dataclasses import dataclass, field
from xml.sax.saxutils import quoteattr

import numpy as np
import yaml

from tests.fuzz.random_problems.arms import following, limb, turns
from tests.fuzz.random_problems.case import Arm, Source
from tests.fuzz.random_problems.chain import read_chain
from tests.fuzz.random_problems.shapes import Body, as_mesh, box, mesh_file

MOST_JOINTS = 14
WORDS = ("link", "upper arm", "Gelenk ß", "関節", "глава", "l'épaule", "a.b/c", "90 %", "<left>", "joint")
"""Names begin so: with spaces, quotes and letters of other scripts."""
MILLIMETRES = " mm"
"""In the name of a mesh's file: it is in millimetres, and the URDF scales it."""
GRAVITY = 9.81
HOLDS = 3.0
"""Effort limits over the load of the whole robot stretched out: it can be held everywhere, and moved."""


@dataclass
class Part:
    """A link with the joint that it hangs on; `far` is where its end is, along its own x [m].

    `knob` is a second body, beside the first.
    """

    link: str
    joint: str
    kind: str
    parent: int
    at: str
    far: float
    body: Body | None
    mass: float | None
    low: float = 0.0
    high: float = 0.0
    axis: str = "1 0 0"
    mimic: int | None = None
    tag: str = ""
    knob: Body | None = None


@dataclass
class Robot:
    """Parts from the root outward; the root's own joint is none."""

    parts: list[Part] = field(default_factory=list)
    meshes: dict[str, Body] = field(default_factory=dict)


def any_robot(rng: np.random.Generator, *, tree: bool = False, mimics: bool = False) -> Arm:
    """Return a robot of 2 to 14 joints that move, of which a group is planned.

    Args:
        rng: Draws it.
        tree: Whether links may branch.
        mimics: Whether some joints follow others, in chains too.
    """
    robot, names = Robot(), Names(rng)
    root = "world" if rng.random() < 0.1 else names.link()
    robot.parts.append(Part(root, "", "", -1, "", 0.0, box(0.08, 0.08, 0.06), _mass(rng)))
    count, moving = int(rng.integers(2, MOST_JOINTS + 1)), 0
    while moving < count:
        welded = rng.random() < 0.15
        _grow(robot, names, rng, tree=tree, mimics=mimics, welded=welded)
        moving += not welded
    return _arm(robot, rng)


class Names:
    """Names that nobody has yet; joints may be called as a link is."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.plain = rng.random() < 0.3
        self.links: list[str] = []
        self.joints: list[str] = []

    def link(self) -> str:
        word = "link" if self.plain else str(self.rng.choice(WORDS))
        self.links.append(f"{word} {len(self.links)}" if not self.plain else f"{word}{len(self.links)}")
        return self.links[-1]

    def joint(self) -> str:
        """Return a name of its own, or that of any link, where no joint has it yet."""
        free = [name for name in self.links if name not in self.joints]
        if free and self.rng.random() < 0.2:
            name = str(self.rng.choice(free))
        else:
            name = f"{self.rng.choice(WORDS[:-1]) if not self.plain else 'j'}-{len(self.joints)}"
        self.joints.append(name)
        return name


def _mass(rng: np.random.Generator) -> float | None:
    """Draw a mass [kg]: none stated, none at all, or some."""
    return [None, 0.0, float(rng.uniform(0.1, 2.0))][int(rng.choice(3, p=[0.3, 0.2, 0.5]))]


def _grow(
    robot: Robot, names: Names, rng: np.random.Generator, *, tree: bool, mimics: bool, welded: bool
) -> None:
    """Add a link with its joint."""
    last = len(robot.parts) - 1
    parent = int(rng.integers(len(robot.parts))) if tree and rng.random() < 0.25 else last
    turn = "0 0 0"
    if parent != last:  # a branch leaves its parent sideways
        turn = f"0 0 {float(rng.choice([-1, 1]) * rng.uniform(0.6, 1.4)):.4f}"
    above = "0 0 0.08" if parent == 0 else f"{robot.parts[parent].far:.4f} 0 0"
    part = Part(
        names.link(), names.joint(), "fixed", parent, f'xyz="{above}" rpy="{turn}"',
        float(rng.uniform(0.1, 0.25)), None, _mass(rng),
    )  # fmt: skip
    if welded:
        part.far = 0.0 if rng.random() < 0.5 else part.far
        part.body = limb(rng, part.far) if part.far else None  # no more than a frame, often
        robot.parts.append(part)
        return
    part.kind = str(rng.choice(["revolute", "prismatic", "continuous"], p=[0.7, 0.15, 0.15]))
    part.body = _shape(robot, rng, part.far)
    part.knob = box(0.03, 0.02, 0.02) if part.body is not None and rng.random() < 0.15 else None
    part.axis = " ".join(f"{value:.3f}" for value in rng.normal(size=3))
    movers = [place for place, item in enumerate(robot.parts) if item.kind not in ("", "fixed")]
    if mimics and movers and rng.random() < 0.4:
        leader = movers[-1] if rng.random() < 0.6 else int(rng.choice(movers))
        ahead = robot.parts[leader]
        part.mimic, part.kind = leader, "prismatic" if ahead.kind == "prismatic" else "revolute"
        part.low, part.high, part.tag = following(
            rng, ahead.joint, (ahead.low, ahead.high, ahead.kind), False
        )
    elif part.kind == "prismatic":
        part.low, part.high = -0.05, float(rng.uniform(0.08, 0.2))
    else:  # what follows a joint without limits has some, and so that joint has too
        part.low, part.high = turns(rng)
    robot.parts.append(part)


def _shape(robot: Robot, rng: np.random.Generator, length: float) -> Body | None:
    """Draw what is on a link: a primitive, a mesh in a file, or nothing."""
    if rng.random() < 0.1:
        return None
    body = limb(rng, length)
    if rng.random() < 0.75:
        return body
    unit = MILLIMETRES if rng.random() < 0.3 else ""
    name = f"meshes/part {len(robot.meshes)}{unit}.{rng.choice(['stl', 'obj'])}"
    robot.meshes[name] = as_mesh(body, rng)
    return robot.meshes[name]


def _arm(robot: Robot, rng: np.random.Generator) -> Arm:
    """Write the files, choose what is planned, and read them."""
    name_of = {id(body): name for name, body in robot.meshes.items()}
    load = GRAVITY * sum((part.mass or 0.0) for part in robot.parts)
    long = sum(part.far + (part.high if part.kind == "prismatic" else 0.0) for part in robot.parts)
    effort = [HOLDS * load * max(long, 1.0) + 10.0, 0.0, 1e6][int(rng.choice(3, p=[0.8, 0.1, 0.1]))]
    text = [_link(part, name_of) for part in robot.parts]
    limits: dict[str, dict[str, object]] = {}
    for part in robot.parts[1:]:
        text.append(_joint(part, robot.parts[part.parent].link, effort, rng))
        if part.kind != "fixed":
            most = float(rng.uniform(1.0, 10.0))
            limits[part.joint] = {"has_acceleration_limits": True, "max_acceleration": most}
    urdf = f"<robot name={quoteattr('robot ' + robot.parts[0].link)}>{''.join(text)}</robot>"
    stated = yaml.safe_dump({"joint_limits": limits}, allow_unicode=True)
    group, srdf, driven, tip = _group(robot, rng)
    chain = read_chain(urdf, driven=driven, srdf=srdf, limits=stated, packages=robot.meshes)
    files = tuple(
        (name, mesh_file(body, name, 1000.0 if MILLIMETRES in name else 1.0))
        for name, body in robot.meshes.items()
    )
    return Arm(Source("", urdf, srdf, stated, files), group, chain, tip)


def _group(robot: Robot, rng: np.random.Generator) -> tuple[str, str, tuple[str, ...] | None, str]:
    """Choose what is planned: all joints without an SRDF, or those between the root and a link with one."""
    ends = [
        place
        for place, part in enumerate(robot.parts)
        if place and part.body is not None and part.mimic is None and part.kind != "fixed"
    ]
    tip = ends[-1] if ends else len(robot.parts) - 1
    way: list[Part] = []
    place = tip
    while place > 0:
        way.insert(0, robot.parts[place])
        place = robot.parts[place].parent
    driven = tuple(part.joint for part in way if part.kind != "fixed" and part.mimic is None)
    if rng.random() < 0.5 or len(driven) < 2:
        return "all", "", None, robot.parts[tip].link
    name = str(rng.choice(["arm", "left arm", "Ärmchen"]))
    ends_of = f"base_link={quoteattr(robot.parts[0].link)} tip_link={quoteattr(robot.parts[tip].link)}"
    srdf = f'<robot name="any"><group name={quoteattr(name)}><chain {ends_of}/></group></robot>'
    return name, srdf, driven, robot.parts[tip].link


def _link(part: Part, name_of: dict[int, str]) -> str:
    inside = ""
    if part.mass is not None:
        size = 0.01 * part.mass
        inside = (
            f'<inertial><origin xyz="{part.far / 2:.4f} 0 0"/><mass value="{part.mass!r}"/>'
            f'<inertia ixx="{size!r}" iyy="{size!r}" izz="{size!r}" ixy="0" ixz="0" iyz="0"/></inertial>'
        )
    if part.body is not None:
        lying = ' rpy="0 1.5707963267948966 0"' if part.body.kind == "cylinder" else ""
        name = name_of.get(id(part.body))
        scale = ' scale="0.001 0.001 0.001"' if name is not None and MILLIMETRES in name else ""
        shape = part.body.urdf if name is None else f"<mesh filename={quoteattr(name)}{scale}/>"
        height = -0.02 if part.parent < 0 else 0.0
        inside += (
            f'<collision><origin xyz="{part.far / 2:.6f} 0 {height}"{lying}/><geometry>{shape}</geometry>'
            "</collision>"
        )
    if part.knob is not None:
        inside += (
            f'<collision name="knob"><origin xyz="{part.far / 2:.6f} 0.03 0" rpy="0.3 0 1"/><geometry>'
            f"{part.knob.urdf}</geometry></collision>"
        )
    return f"<link name={quoteattr(part.link)}>{inside}</link>"


def _joint(part: Part, parent: str, effort: float, rng: np.random.Generator) -> str:
    ends = f"<parent link={quoteattr(parent)}/><child link={quoteattr(part.link)}/><origin {part.at}/>"
    head = f"<joint name={quoteattr(part.joint)} type={quoteattr(part.kind)}>{ends}"
    if part.kind == "fixed":
        return f"{head}</joint>"
    bounds = "" if part.kind == "continuous" else f'lower="{part.low!r}" upper="{part.high!r}" '
    limit = f'<limit {bounds}effort="{effort!r}" velocity="{float(rng.uniform(0.3, 2.5))!r}"/>'
    return f'{head}<axis xyz="{part.axis}"/>{limit}{part.tag}</joint>'
