"""A random problem as plain numbers: trajopt's problem is made of them, and the check reads them."""

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np

import trajopt as to
from tests.fuzz.random_problems.asked import Asked
from tests.fuzz.random_problems.chain import Chain, Placed
from tests.fuzz.random_problems.shapes import Body
from trajopt.values.arrays import Floats


@dataclass(frozen=True)
class Source:
    """Where a robot comes from: an installed name, or its files: their text, and the meshes by name."""

    name: str = ""
    urdf: str = ""
    srdf: str = ""
    limits: str = ""
    meshes: tuple[tuple[str, bytes], ...] = ()

    def robot(self) -> to.Robot:
        """Load it."""
        return _loaded(self)


@cache
def _loaded(source: Source) -> to.Robot:
    if source.name:
        return to.load(source.name)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "arm.urdf").write_text(source.urdf)
        (folder / "arm.srdf").write_text(source.srdf)
        (folder / "limits.yaml").write_text(source.limits)
        for mesh, held in source.meshes:
            (folder / mesh).parent.mkdir(exist_ok=True)
            (folder / mesh).write_bytes(held)
        return to.load(
            folder / "arm.urdf",
            srdf=folder / "arm.srdf" if source.srdf else None,
            limits=folder / "limits.yaml" if source.limits else None,
        )


@dataclass(frozen=True, eq=False)
class Arm:
    """A robot for both sides: trajopt's source of it, and the check's own chain.

    `efforts`: what each driven joint can bear [Nm | N]; none where that is no matter.
    """

    source: Source
    group: str
    chain: Chain
    tip: str
    efforts: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Thing:
    """An object in the scene: placed in the world, or on a link; `exact` keeps its triangles."""

    name: str
    body: Body
    place: Floats
    link: str = "world"
    touch: tuple[str, ...] = ()


@dataclass(frozen=True)
class Contact:
    """A pair that may touch during the first or last seconds, no deeper than stated [m]."""

    first_name: str
    second_name: str
    depth: float
    first: float
    last: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Case:
    """A problem.

    Attributes:
        arm: The robot.
        start: Of the driven joints, shape (n,) [rad | m].
        goals: What must hold at the end.
        path: What must hold all the way.
        things: What is around the arm.
        margin: Clearance that is wished for [m].
        pair_margins: The same by pair.
        required: Clearance that is demanded of everything [m].
        pair_required: The same by pair.
        kind_required: The same by kind: "world", "carried", "robot".
        contacts: Contacts that are meant.
        motion: Corners of a polyline from the start that holds all of it, if one is known.
        impossible: Why there is no motion, where that is known.
    """

    arm: Arm
    start: Floats
    goals: tuple[Asked, ...]
    path: tuple[Asked, ...] = ()
    things: tuple[Thing, ...] = ()
    margin: float = 0.005
    pair_margins: Mapping[frozenset[str], float] = field(default_factory=dict)
    required: float = 0.0
    pair_required: Mapping[frozenset[str], float] = field(default_factory=dict)
    kind_required: Mapping[str, float] = field(default_factory=dict)
    contacts: tuple[Contact, ...] = ()
    motion: Floats | None = None
    impossible: str = ""

    @property
    def start_by_name(self) -> dict[str, float]:
        """Joint -> position, of the driven ones and of those that stand still."""
        driven = dict(zip(self.arm.chain.driven, np.asarray(self.start).tolist(), strict=True))
        return {**self.arm.chain.still, **driven}

    def scene(self) -> to.Scene:
        """Make trajopt's scene."""
        scene = to.Scene(self.arm.source.robot(), margin=self.margin)
        for thing in self.things:
            place = to.Placement(thing.place[:3, :3], thing.place[:3, 3])
            exact = to.MeshPolicy(exact=True) if thing.body.kind == "mesh" else None
            scene = scene.add(
                thing.name, thing.body.asked, place, frame=thing.link, touch_links=thing.touch, meshes=exact
            )
        for pair, margin in self.pair_margins.items():
            scene = scene.with_margin(margin, *sorted(pair))
        if self.required:
            scene = scene.with_clearance(self.required)
        if self.kind_required:
            scene = scene.with_clearance(**self.kind_required)
        for pair, required in self.pair_required.items():
            scene = scene.with_clearance(required, *sorted(pair))
        for count, item in enumerate(self.contacts):
            scene = scene.allow_contact(
                f"contact{count}", item.first_name, item.second_name, depth=item.depth, first=item.first,
                last=item.last,
            )  # fmt: skip
        return scene

    def problem(self) -> to.Problem:
        """Make trajopt's problem."""
        return to.Problem(
            scene=self.scene(),
            group=self.arm.group,
            start=self.start_by_name,
            goal=[goal.requirement() for goal in self.goals],
            constraints=[item.requirement() for item in self.path],
        )

    def placed(self) -> tuple[Placed, ...]:
        """All bodies: the links' and the things'."""
        return (
            *self.arm.chain.bodies,
            *(Placed(thing.name, thing.link, thing.place, thing.body) for thing in self.things),
        )

    def may_touch(self, first: str, second: str) -> bool:
        """Whether two owners are excused from keeping apart."""
        by_name = {thing.name: thing for thing in self.things}
        for one, other in ((first, second), (second, first)):
            if one in by_name and other in by_name[one].touch:
                return True
        return frozenset((first, second)) in self.arm.chain.excused

    def required_of(self, first: str, second: str) -> float:
        """The clearance that two owners must keep [m]."""
        by_name = {thing.name: thing.link for thing in self.things}
        links = [by_name.get(name) for name in (first, second)]
        kinds = {"world"} if "world" in links else set()
        kinds |= {"carried"} if set(links) - {None, "world"} else set()
        stated = [self.kind_required[kind] for kind in kinds or {"robot"} if kind in self.kind_required]
        return self.pair_required.get(frozenset((first, second)), max(stated, default=self.required))
