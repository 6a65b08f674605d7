"""Families of goals, starts, mimics, clearances and margins."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tests.fuzz.random_problems.arms import installed, planar, random_arm
from tests.fuzz.random_problems.asked import Coupled, Joints, Pointing, near
from tests.fuzz.random_problems.case import Arm, Case, Thing
from tests.fuzz.random_problems.check import Pair, fault_of_path
from tests.fuzz.random_problems.drawing import at, at_end, clear, cluttered, joints_at_end, moving
from tests.fuzz.random_problems.shapes import sphere
from trajopt.values.arrays import Floats


def joint_tolerance(rng: np.random.Generator) -> Case:
    """Goals of joints with tolerances from 1e-4 to 0.8 rad, the centre beyond a limit or inside a thing."""
    case = moving(rng)
    chain, end = case.arm.chain, case.motion[-1]
    low, high = chain.bounds()
    wide = 10.0 ** rng.uniform(-4.0, np.log10(0.8), len(end))
    if rng.random() < 0.7:
        wide[int(rng.integers(len(end)))] = float(rng.uniform(0.3, 0.8))
    centre = end + rng.uniform(-0.95, 0.95, len(end)) * wide
    if rng.random() < 0.3:  # beyond a limit, as far as the tolerance lets it
        joint = int(np.argmax(wide))
        centre[joint] = end[joint] + 0.97 * wide[joint] * (
            1 if high[joint] - end[joint] < end[joint] - low[joint] else -1
        )
    if rng.random() < 0.5:
        spot = chain.places(np.clip(centre, low, high)[None])[case.arm.tip][0][:3, 3]
        trial = replace(case, things=(Thing("on_centre", sphere(float(rng.uniform(0.02, 0.08))), at(spot)),))
        case = trial if clear(trial) else case
    case = cluttered(case, rng, int(rng.integers(0, 4)))
    below, above = wide.copy(), wide.copy()
    if rng.random() < 0.3:  # one-sided
        above = np.where(end <= centre, 0.0, above)
        below = np.where(end > centre, 0.0, below)
    names = [name for name in chain.driven if rng.random() < 0.85] or [chain.driven[0]]
    pick = [chain.driven.index(name) for name in names]
    goal = Joints(
        *(dict(zip(names, values[pick].tolist(), strict=True)) for values in (centre, below, above))
    )
    return replace(case, goals=(goal,))


def two_goals(rng: np.random.Generator) -> Case:
    """Two goals for one joint: sets that overlap, by a hair too, or that do not."""
    case = moving(rng)
    joint = int(rng.integers(len(case.arm.chain.driven)))
    name, there = case.arm.chain.driven[joint], float(case.motion[-1][joint])
    first, second = 10.0 ** rng.uniform(-3.0, -0.2, 2)
    shared = float(rng.choice([2e-4, 0.02, 0.3])) * min(first, second)
    gap = float(rng.choice([1e-3, 0.05])) if rng.random() < 0.4 else -shared
    middle = there if gap > 0 else there + 0.5 * shared
    centres = middle - first, middle + gap + second
    if gap < 0:
        centres = there + 0.5 * shared - first, there - 0.5 * shared + second
    goals = tuple(near({name: float(c)}, float(w)) for c, w in zip(centres, (first, second), strict=True))
    others = {
        other: float(q)
        for other, q in zip(case.arm.chain.driven, case.motion[-1], strict=True)
        if other != name
    }
    if others and rng.random() < 0.6:
        goals = (*goals, near(others, 1e-2))
    why = f"two goals of {name} are {gap:g} apart" if gap > 0 else ""
    return replace(
        cluttered(case, rng, int(rng.integers(0, 3))), goals=goals, impossible=why,
        motion=None if why else case.motion,
    )  # fmt: skip


def near_start(rng: np.random.Generator) -> Case:
    """Starts within 1e-6 of a limit, of a thing or of the bound of a requirement."""
    case = moving(rng)
    kind = str(rng.choice(["limit", "thing", "cone", "coupled", "broken"]))
    hair = float(10.0 ** rng.uniform(-9.0, -6.0))
    chain = case.arm.chain
    if kind == "limit":
        low, high = chain.bounds()
        by_name = {joint.name: joint for joint in chain.moving}
        finite = [place for place, name in enumerate(chain.driven) if by_name[name].kind != "continuous"]
        start = case.start.copy()
        for joint in finite[: int(rng.integers(1, 3))]:
            start[joint] = high[joint] - hair if rng.random() < 0.5 else low[joint] + hair
        case = _from(case, start)
    elif kind == "thing":
        case = replace(case, things=(touching(case, rng, case.start, hair),))
    elif kind in ("cone", "broken"):
        axis, direction = rng.normal(size=3), rng.normal(size=3)
        cone = Pointing(case.arm.tip, axis, direction, 0.0)
        angle = float(cone.excess(chain, case.start[None], chain.places(case.start[None]))[0])
        less = 0.05 if kind == "broken" else -hair
        case = replace(case, path=(replace(cone, cone=float(np.clip(angle - less, 0.01, 3.1))),))
    else:
        weights = {name: float(rng.normal()) for name in chain.driven[:3]}
        total = sum(weights[name] * float(case.start[chain.driven.index(name)]) for name in weights)
        case = replace(case, path=(Coupled(weights, total + 0.3, 0.3 + hair),))
    case = at_end(case, rng)
    if kind == "broken" and fault_of_path(case, case.start[None].repeat(2, axis=0)).startswith("breaks"):
        return replace(case, motion=None, impossible="the start breaks what must hold all the way")
    return case if not fault_of_path(case, case.motion) else replace(case, motion=None)


def _from(case: Case, start: Floats) -> Case:
    return replace(case, start=start, motion=np.concatenate((start[None], case.motion[1:])))


def touching(case: Case, rng: np.random.Generator, there: Floats, gap: float, name: str = "close") -> Thing:
    """Return a ball at a distance from the tip, standing where it is at a configuration."""
    places = case.arm.chain.places(there[None])
    tip = next(item for item in case.arm.chain.bodies if item.link == case.arm.tip)
    body = sphere(float(rng.uniform(0.02, 0.1)))
    along = rng.normal(size=3)
    along /= np.linalg.norm(along)
    middle = (places[tip.link] @ tip.place)[0][:3, 3]
    near_by, far = 0.0, tip.body.radius + body.radius + 0.1
    for _ in range(60):
        half = (near_by + far) / 2.0
        placed = replace(tip, owner=name, link="world", place=at(middle + half * along), body=body)
        far, near_by = (half, near_by) if Pair(case, tip, placed, places).gap(0) > gap else (far, half)
    return Thing(name, body, at(middle + far * along))


def mimic_chain(rng: np.random.Generator) -> Case:
    """Chains of followers, with goals of driven joints, of followers or of the tip."""
    case = moving(rng, lambda rng: random_arm(rng, mimics=True))
    return _with_followers(cluttered(case, rng, int(rng.integers(0, 4))), rng)


def mimic_limits(rng: np.random.Generator) -> Case:
    """Followers with narrower limits than what they follow, and goals that only the leader could hold."""
    case = moving(rng, lambda rng: random_arm(rng, mimics=True, tight=True))
    chain = case.arm.chain
    if rng.random() < 0.6:
        return _with_followers(cluttered(case, rng, int(rng.integers(0, 3))), rng)
    low, high = chain.bounds()
    for _ in range(50):
        there = rng.uniform(low, high)
        if 0.02 < chain.excess_of_limits(there[None]):
            case = replace(case, motion=np.stack((case.start, there)))
            why = "a follower would be beyond its limits at the goal"
            return replace(case, goals=(joints_at_end(case, 1e-4),), motion=None, impossible=why)
    return _with_followers(case, rng)


def _with_followers(case: Case, rng: np.random.Generator) -> Case:
    chain = case.arm.chain
    followers = [joint.name for joint in chain.moving if joint.mimic is not None]
    if not followers or rng.random() < 0.85:
        return at_end(case, rng)
    names = [joint.name for joint in chain.moving]
    values = chain.all_joints(case.motion[-1:])[0]
    goal = near(
        {name: float(values[names.index(name)]) for name in followers[:2]}, float(rng.choice([1e-3, 0.05]))
    )
    return replace(case, goals=(goal,))


def clearance_of_all(rng: np.random.Generator) -> Case:
    """A clearance that everything must keep, larger or smaller than the wish."""
    required = float(rng.uniform(0.002, 0.03))
    case = moving(rng, required=required, margin=float(rng.choice([0.0, 0.005, 0.04])))
    case = at_end(cluttered(case, rng, int(rng.integers(1, 5))), rng)
    if rng.random() < 0.15:
        close = touching(case, rng, case.start, required - 1e-3)
        return replace(
            case,
            things=(*case.things, close),
            motion=None,
            impossible="the start keeps less than is required",
        )
    return case


def clearance_of_pairs(rng: np.random.Generator) -> Case:
    """Clearances that single pairs must keep, beside one for everything or none."""
    case = moving(rng, margin=float(rng.choice([0.0, 0.01])))
    case = cluttered(replace(case, required=float(rng.choice([0.0, 0.003]))), rng, int(rng.integers(2, 5)))
    links = [item.owner for item in case.arm.chain.bodies if item.owner != case.arm.chain.root]
    for thing in case.things:
        for link in rng.choice(links, size=2):
            pair = frozenset((thing.name, str(link)))
            trial = replace(
                case, pair_required={**case.pair_required, pair: float(rng.choice([0.0, 0.005, 0.02, 0.06]))}
            )
            case = trial if clear(trial) else case
    return at_end(case, rng)


def clearance_of_kinds(rng: np.random.Generator) -> Case:
    """A clearance from the world, of what is carried and of the robot itself, each its own or none."""
    sizes = {"world": (0.0, 0.01, 0.03), "carried": (0.0, 0.005, 0.02), "robot": (0.0, 0.002)}
    kinds = {kind: float(rng.choice(some)) for kind, some in sizes.items() if rng.random() < 0.7}
    required = float(rng.choice([0.0, 0.001]))
    case = moving(rng, required=required, kind_required=kinds, margin=float(rng.choice([0.0, 0.01])))
    size = float(rng.uniform(0.005, 0.03))
    held = Thing("held", sphere(size), at(rng.normal(scale=0.1, size=3)), case.arm.tip, (case.arm.tip,))
    trial = replace(case, things=(held,))
    case = cluttered(trial if clear(trial) else case, rng, int(rng.integers(2, 5)))
    if not clear(case):  # things are only drawn beside the arm, not beside what it carries
        case = replace(case, things=tuple(thing for thing in case.things if thing is not held))
    close = Thing("close", sphere(0.05), np.eye(4))
    least = replace(case, things=(*case.things, close)).required_of(case.arm.tip, "close")
    if rng.random() < 0.2 and least > 0.0:
        near_by = touching(case, rng, case.start, 0.5 * least)
        why = "the start is nearer to the world than is required"
        near_by_too = replace(at_end(case, rng), things=(*case.things, near_by))
        return replace(near_by_too, motion=None, impossible=why)
    return at_end(case, rng)


def margins(rng: np.random.Generator) -> Case:
    """Wishes of clearance that the known motion does not keep: no reason to refuse."""
    case = cluttered(moving(rng, margin=float(rng.choice([0.0, 0.03, 0.1]))), rng, int(rng.integers(1, 5)))
    links = [item.owner for item in case.arm.chain.bodies]
    wishes = {
        frozenset((thing.name, str(rng.choice(links)))): float(rng.choice([0.0, 0.02, 0.2]))
        for thing in case.things
    }
    return at_end(replace(case, pair_margins=wishes), rng)


def walls(rng: np.random.Generator) -> Case:
    """A planar arm between many things, with a hair to spare."""
    case = moving(
        rng, lambda rng: planar(rng, int(rng.integers(2, 4))), margin=float(rng.choice([0.0, 0.002]))
    )
    case = cluttered(case, rng, 9, spare=5e-4)
    return replace(case, goals=(joints_at_end(case, 1e-4),))


def installed_arm(name: str) -> Callable[[np.random.Generator], Arm]:
    return lambda rng: installed(name)
