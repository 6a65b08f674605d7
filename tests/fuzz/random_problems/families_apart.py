"""Families of exact meshes, contact that is meant, requirements that hold together or exclude each other."""

from dataclasses import replace

import numpy as np

from tests.fuzz.random_problems.arms import installed
from tests.fuzz.random_problems.asked import Apart, Asked, Coupled, Pointing, Within, near
from tests.fuzz.random_problems.case import Case, Contact, Thing
from tests.fuzz.random_problems.check import HULLS, fault_of_path
from tests.fuzz.random_problems.drawing import (
    at,
    at_end,
    clear,
    cluttered,
    joints_at_end,
    moved,
    moving,
    small_arm,
)
from tests.fuzz.random_problems.families import touching
from tests.fuzz.random_problems.shapes import ball, box
from trajopt.values.arrays import Floats


def open_meshes(rng: np.random.Generator) -> Case:
    """Exact meshes that bound nothing."""
    return at_end(cluttered(moving(rng), rng, int(rng.integers(1, 4)), kinds="open"), rng)


def closed_meshes(rng: np.random.Generator) -> Case:
    """Exact meshes that bound solids; at times what the arm carries would have to end wholly inside one."""
    case = moving(rng)
    chain, size = case.arm.chain, float(rng.uniform(0.005, 0.02))
    beyond = np.eye(4)
    beyond[:3, 3] = (float(rng.uniform(0.45, 0.6)), 0.0, 0.0)
    chip = Thing("chip", box(size, size, size), beyond, case.arm.tip, (case.arm.tip,))
    carrying = replace(case, things=(chip,))
    if not clear(carrying):
        return at_end(cluttered(case, rng, int(rng.integers(1, 4)), kinds="closed"), rng)
    spot = (chain.places(case.motion[-1:])[case.arm.tip] @ beyond)[0][:3, 3]
    if rng.random() < 0.5:
        return at_end(cluttered(carrying, rng, 4, kinds="closed"), rng)
    solid = Thing("solid", ball(float(rng.uniform(0.05, 0.09))), at(spot))
    contacts = (Contact("chip", "solid", 1e-3, 0.0, 0.5),) if rng.random() < 0.6 else ()
    return replace(
        carrying, things=(chip, solid), contacts=contacts, motion=None, goals=(joints_at_end(case, 1e-4),),
        impossible="what is carried would end inside a solid",
    )  # fmt: skip


def meant_contact(rng: np.random.Generator) -> Case:
    """Contact that is meant at the start or the end, not deeper than it may be, or deeper."""
    case = moving(rng)
    last = rng.random() < 0.6
    there = case.motion[-1] if last else case.motion[0]
    deep = float(rng.choice([3e-4, 8e-4, 6e-3]))
    thing = touching(case, rng, there, -deep, "meant")
    if rng.random() < 0.4:  # the same place, as triangles: a ball inside the round one
        thing = replace(thing, body=ball(thing.body.sizes[0]))
    window = float(rng.choice([0.3, 1.0]))
    contact = Contact("meant", case.arm.tip, 1e-3, 0.0 if last else window, window if last else 0.0)
    case = replace(case, things=(thing,), contacts=(contact,), goals=(joints_at_end(case, 1e-4),))
    return case if not fault_of_path(case, case.motion) else replace(case, motion=None)


def kept_requirements(rng: np.random.Generator) -> Case:
    """Requirements all the way that a known motion holds."""
    case = cluttered(moving(rng), rng, int(rng.integers(0, 4)))
    asked = [along(case, rng) for _ in range(int(rng.integers(1, 3)))]
    return at_end(replace(case, path=tuple(asked)), rng)


def along(case: Case, rng: np.random.Generator) -> Asked:
    """Return a requirement that the motion holds with something to spare."""
    chain, tip = case.arm.chain, case.arm.tip
    parts = [np.linspace(a, b, 200) for a, b in zip(case.motion[:-1], case.motion[1:], strict=True)]
    fine = np.concatenate(parts)
    places = chain.places(fine)
    points = places[tip][:, :3, 3]
    kind = int(rng.integers(4))
    if kind == 0:
        return Within(tip, points.min(axis=0) - 0.02, points.max(axis=0) + 0.02)
    if kind == 1:
        axis, direction = (
            rng.normal(size=3),
            places[tip][int(rng.integers(len(fine)))][:3, :3] @ rng.normal(size=3),
        )
        wanted = Pointing(tip, axis, direction, 0.0)
        return replace(wanted, cone=float(min(wanted.excess(chain, fine, places).max() + 0.03, 3.1)))
    if kind == 2:
        between = np.linalg.norm(points - places[chain.root][:, :3, 3], axis=1)
        return Apart(tip, chain.root, float(max(between.min() - 0.02, 0.0)), float(between.max() + 0.02))
    weights = {name: float(rng.normal()) for name in chain.driven[:3]}
    total = sum(weight * fine[:, chain.driven.index(name)] for name, weight in weights.items())
    return Coupled(weights, float((total.min() + total.max()) / 2.0), float(np.ptp(total) / 2.0 + 0.02))


def conflicts(rng: np.random.Generator) -> Case:
    """Couplings of joints and goals: on a motion that holds all of them, or with none that could."""
    return _coupled(moving(rng, small_arm), rng)


def conflicts_panda(rng: np.random.Generator) -> Case:
    """The same for the Panda."""
    case = None
    while case is None:
        case = moved(installed("panda"), rng, spare=HULLS)
    return _coupled(case, rng)


def _coupled(case: Case, rng: np.random.Generator) -> Case:
    names, count = case.arm.chain.driven, len(case.arm.chain.driven)
    rows = rng.normal(size=(min(int(rng.integers(1, 3)), count - 1) or 1, count))
    rows[np.abs(rows) < 0.5] = 0.0
    rows[:, 0] += 0.7
    kept = _within(case, rows)
    values, tight = rows @ case.start, float(rng.choice([1e-3, 1e-2, 0.1]))
    path: list[Asked] = [
        Coupled(dict(zip(names, row.tolist(), strict=True)), float(value), tight)
        for row, value in zip(rows, values, strict=True)
    ]
    if rng.random() < 0.6 and kept is not None and count > 1:
        case = replace(case, motion=kept, path=tuple(path))
        return case if not fault_of_path(case := at_end(case, rng), kept) else replace(case, motion=None)
    beyond = tight + float(rng.choice([0.01, 0.2]))
    if rng.random() < 0.5:  # the goal breaks what must hold all the way
        there = case.motion[-1]
        off = float(rows[0] @ (there - case.start))
        if abs(off) < beyond:
            there = there + rows[0] * (beyond + 0.1 - off) / float(rows[0] @ rows[0])
        goal = near(dict(zip(names, there.tolist(), strict=True)), 1e-4)
        why = (
            "the goal of joints breaks a coupling"
            if abs(rows[0] @ (there - case.start)) > tight + 2e-3
            else ""
        )
        return replace(case, path=tuple(path), goals=(goal,), motion=None, impossible=why)
    first = path[0]
    assert isinstance(first, Coupled)
    other = replace(first, value=first.value + 2.0 * beyond)
    why = "two couplings of the same sum exclude each other"
    return replace(case, path=tuple(path), goals=(other,), motion=None, impossible=why)


def _within(case: Case, rows: Floats) -> Floats | None:
    """Return the motion put onto what keeps weighted sums, if it stays within limits."""
    free = np.eye(rows.shape[1]) - np.linalg.pinv(rows) @ rows
    corners = case.start + (case.motion - case.start) @ free.T
    inside = case.arm.chain.excess_of_limits(corners) < 0.0
    return corners if inside and np.abs(corners[-1] - corners[0]).max() > 0.05 else None


def clutter(name: str):
    """Return the family of an installed arm among things."""

    def draw(rng: np.random.Generator) -> Case:
        case = None
        while case is None:
            case = moved(installed(name), rng, spare=HULLS)
        case = cluttered(case, rng, int(rng.integers(1, 5)), spare=HULLS)
        if rng.random() < 0.3:
            case = replace(case, path=(along(case, rng),))
        return at_end(case, rng)

    return draw
