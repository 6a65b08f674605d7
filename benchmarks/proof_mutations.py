"""Mutations of proof files: the checker accepts none whose statement is false.

python -m benchmarks.proof_mutations [--count 100000] [--kept FILE] [--page FILE]

Six small proofs are changed in twelve ways. A changed file that the checker accepts is false if scipy, Coal
and Pinocchio refute its statement at one of 100 times. Blocks of mutations are stored, and not repeated by a
later call. The fast kernel checks each file too.
"""

import argparse
import copy
import hashlib
import json
import math
import os
import struct
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from tests.files.proof.conftest import Checker, Document, Proof, loaded_checker
from tests.files.proof.dense import of_kind, refuted, torques
from trajopt.files.proof import MotionProof, save_proof
from trajopt.values.errors import FileFormatError

KEPT = Path(__file__).parent / "results" / "proof_mutations.json"
BLOCK = 2_500
MALFORMED, UNSHOWN, SAME, TRUE, FALSE, CRASH = (
    "not a proof", "not proven", "accepted, unchanged", "accepted, true", "accepted, false", "crash",
)  # fmt: skip
KERNELS = {
    (True, True): "both accept",
    (False, False): "both refuse",
    (True, False): "the checker alone accepts",
    (False, True): "the fast kernel alone accepts",
}
JOINTS = ("joint1", "joint2")
Mutation = Callable[[Proof, Proof, np.random.Generator], bytes]
"""Returns the bytes of a changed proof; the second proof is one to take parts from."""


def direct(start: tuple[float, float], goal: tuple[float, float], duration: float) -> to.Trajectory:
    """Return the polynomial of degree 5 from rest to rest, in four pieces."""
    s = np.linspace(0.0, 1.0, 5)[:, None]
    way = np.array(goal) - start
    return to.Trajectory(
        JOINTS,
        duration * s[:, 0],
        start + way * s**3 * (10.0 - 15.0 * s + 6.0 * s**2),
        way * 30.0 * s**2 * (1.0 - s) ** 2 / duration,
        way * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / duration**2,
    )


def cases() -> Iterator[tuple[to.Problem, to.Trajectory]]:
    """Yield problems of a planar arm, and motions for them."""
    bare = to.Scene(to.load("planar2"))
    post = bare.add("post", to.Cylinder(0.04, 0.4), to.placement((0.62, 0.142, 0.1)))
    floor = post.add("floor", to.Plane(), to.placement((0.0, 0.0, -0.05))).allow("floor", "base_link")
    floor = floor.allow_contact("start", "post", "link2", first=0.1, last=0.05)
    track = to.Track.through([0.0, 0.7, 1.9], [to.placement((0.85, y, 0.14)) for y in (0.1, 0.15, 0.4)])
    moved = bare.add("ball", to.Sphere(0.04), motion=to.Prediction(track, (0.002, 0.003, 0.001)))
    moved = moved.add("late", to.Box(0.1, 0.1, 0.1), to.placement((0.72, -0.2, 0.14)), appears=0.9)
    grid = np.stack(np.meshgrid((0.6, 0.62), (0.13, 0.14, 0.15), np.linspace(0.0, 0.2, 5)), axis=-1)
    measured = bare.add("post", to.Points(grid.reshape(-1, 3), 0.01))
    measured = measured.add("cells", to.Voxels([[45, 2, 7], [46, 2, 7], [45, 3, 8]], 0.02))
    room = to.position_in_region("tool", to.Box(2.0, 2.0, 0.5), to.placement((0.0, 0.0, 0.0)))
    start, goal = (-1.1, 0.3), (-0.1, 0.5)
    at = to.position_in_region("tool", to.Sphere(0.05), to.placement((0.86, 0.11, 0.12)))
    placed = to.frame_placement("tool", to.placement((0.85853, 0.15478, 0.14), rpy=(0.0, 0.0, 0.4)))
    along = to.placement((0.6, -0.4, 0.14), rpy=(0.0, 0.0, -0.2))
    rotation = (1e-5, 1e-5, 1.5)
    held = to.frame_placement("tool", along, position_tolerance=(0.8, 0.8, 1e-5), rotation_tolerance=rotation)
    seen = to.frame_placement(
        "base_link",
        along.inverse(),
        reference="tool",
        position_tolerance=(0.9, 0.9, 1e-5),
        rotation_tolerance=rotation,
    )
    later = to.during(to.joint_positions({"joint1": -0.35}, tolerance=0.26), after="half")
    for name, scene, asked in (
        ("past objects", floor, {"goal": to.joint_positions(dict(zip(JOINTS, goal, strict=True)))}),
        ("axes and speed", bare, {"goal": (at, to.axis_alignment("tool", tolerance=0.1)),
                                  "constraints": (room, to.axis_alignment("tool", tolerance=0.1)),
                                  "waypoints": {"half": to.joint_positions({"joint1": -0.6})},
                                  "tool_speed": to.tool_speed("tool", linear=1.8)}),
        ("placement", post, {"goal": placed}),
        ("among moving objects", moved, {"goal": to.joint_positions(dict(zip(JOINTS, goal, strict=True)))}),
        ("held", bare, {"goal": to.joint_positions(dict(zip(JOINTS, goal, strict=True))),
                        "constraints": (held, seen, later, to.gravity_torque()),
                        "waypoints": {"half": to.joint_positions({"joint1": -0.6})},
                        "tool_speed": to.tool_speed("tool", linear=1.8, angular=2.0, steady=0.95),
                        "dwell": 0.2, "finish_by": 1.3}),
        ("past clouds", measured, {"goal": to.joint_positions(dict(zip(JOINTS, goal, strict=True)))}),
    ):  # fmt: skip
        yield to.Problem(scene=scene, start=list(start), name=name, **asked), direct(start, goal, 1.2)


def proofs(folder: Path) -> list[Proof]:
    """Return the proofs of all cases; only the first, to save time, states torques of the motion."""
    found: list[Proof] = []
    for problem, motion in cases():
        save_proof(problem, motion, folder / "x.proof")
        found.append(Proof.read(folder / "x.proof"))
        statement = found[-1].statement
        rules = statement["requirements"]
        rules[:] = [each for each in rules if each["kind"] != "torque" or len(found) == 1]
        for rule in of_kind(statement, "gravity torque"):
            rule["gravity"] = [0.0, -9.81, 0.0]  # across the axes, about which gravity has no torque
            largest = np.abs(torques(statement, rule, np.linspace(1e-6, 1.2 - 1e-6, 1000))).max(axis=0)
            rule["limits"] = [[place, 1.1 * float(largest[place])] for place, _ in rule["limits"]]
    return found


def numbers(value: Any) -> Iterator[tuple[Any, Any]]:
    """Yield the container and the key of every number."""
    for key, part in value.items() if isinstance(value, dict) else enumerate(value):
        if isinstance(part, dict | list):
            yield from numbers(part)
        elif isinstance(part, int | float) and not isinstance(part, bool):
            yield value, key


def changed(value: Any, rng: np.random.Generator) -> float:
    """Return a number near another one, or its opposite, a multiple, or zero."""
    if type(value) is int:
        return max(0, value + int(rng.integers(-1, 2)))
    nudged = value + 10.0 ** rng.uniform(-6.0, 0.5) * rng.standard_normal()
    return float(rng.choice((nudged, nudged, nudged, nudged, -value, 0.5 * value, 2.0 * value, 0.0)))


def in_sections(*sections: str) -> Mutation:
    """Return a change of one or two numbers in some sections of the statement."""

    def mutation(proof: Proof, _: Proof, rng: np.random.Generator) -> bytes:
        statement = copy.deepcopy(proof.statement)
        where = list(
            numbers([statement[name] for name in sections if isinstance(statement[name], list | dict)])
        )
        for _ in range(int(rng.integers(1, 3))):
            container, key = where[rng.integers(len(where))]
            container[key] = changed(container[key], rng)
        return Proof(statement, proof.witness).data

    return mutation


def limits(proof: Proof, _: Proof, rng: np.random.Generator) -> bytes:
    """Change a limit near its largest value in the motion, or any number of joints and ends."""
    statement = copy.deepcopy(proof.statement)
    joint = statement["joints"][rng.integers(len(JOINTS))]
    name = str(rng.choice(("lower", "upper", "velocity", "acceleration", "jerk")))
    joint[name] = joint[name] * rng.uniform(0.0, 1.0)
    return in_sections("joints", "ends")(Proof(statement, proof.witness), _, rng)


def witness_parts(proof: Proof) -> tuple[list[float], list[int], np.ndarray]:
    """Return times, numbers of leaves, and leaves of four numbers each."""
    (count,) = struct.unpack_from("<I", proof.witness)
    pairs = len(proof.statement["pairs"])
    leaves = 4 + 8 * count + 4 * pairs
    return (
        list(struct.unpack_from(f"<{count}d", proof.witness, 4)),
        list(struct.unpack_from(f"<{pairs}I", proof.witness, 4 + 8 * count)),
        np.frombuffer(proof.witness[leaves:], "<u2").reshape(-1, 4).copy(),
    )


def witness_of(times: list[float], counts: list[int], rows: np.ndarray) -> bytes:
    """Return the bytes of a witness."""
    head = struct.pack(f"<I{len(times)}d{len(counts)}I", len(times), *times, *counts)
    return head + rows.astype("<u2").tobytes()


def gaps(proof: Proof, _: Proof, rng: np.random.Generator) -> bytes:
    """Remove, repeat, move or exchange leaves, or change the times."""
    times, counts, rows = witness_parts(proof)
    leaf, other = rng.integers(len(rows), size=2)
    pair = int(np.searchsorted(np.cumsum(counts), leaf, side="right"))
    match rng.integers(7):
        case 0:
            rows, counts[pair] = np.delete(rows, leaf, axis=0), counts[pair] - 1
        case 1:
            rows, counts[pair] = np.insert(rows, leaf, rows[leaf], axis=0), counts[pair] + 1
        case 2:
            rows[leaf, 0] = rng.integers(len(times) + 8)
        case 3:
            rows[[leaf, other]] = rows[[other, leaf]]
        case 4:
            taken = int(rng.integers(len(counts)))
            counts[pair], counts[taken] = counts[pair] - 1, counts[taken] + 1
        case 5 if times:
            times[rng.integers(len(times))] += 10.0 ** rng.uniform(-12.0, 0.0) * rng.standard_normal()
        case _:
            times = sorted({*times, *rng.uniform(0.0, 1.2, 1).tolist()})
    return Proof(proof.statement, witness_of(times, [max(0, count) for count in counts], rows)).data


def directions(proof: Proof, _: Proof, rng: np.random.Generator) -> bytes:
    """Change directions a little or entirely."""
    times, counts, rows = witness_parts(proof)
    leaf, axis = rng.integers(len(rows)), 1 + rng.integers(3)
    rows[leaf, axis] = rng.choice(
        (0, rng.integers(2**16), (int(rows[leaf, axis]) + rng.integers(-999, 999)) % 2**16)
    )
    return Proof(proof.statement, witness_of(times, counts, rows)).data


def pairs(proof: Proof, _: Proof, rng: np.random.Generator) -> bytes:
    """Remove a pair or an excuse, add or rename an excuse, or change a pair's parts or clearance."""
    statement, (times, counts, rows) = copy.deepcopy(proof.statement), witness_parts(proof)
    pair, first = int(rng.integers(len(counts))), np.cumsum([0, *counts])
    one, other = (statement["parts"][part]["owner"] for part in statement["pairs"][pair][:2])
    choice = rng.integers(7)
    if choice in (0, 1):  # with its leaves
        del statement["pairs"][pair]
        rows, counts = (
            np.delete(rows, slice(first[pair], first[pair + 1]), axis=0),
            counts[:pair] + counts[pair + 1 :],
        )
    if choice in (1, 2):
        statement["excused"].append([one, other, "a mutation"])
    if choice == 3:
        del statement["excused"][rng.integers(len(statement["excused"]))]
    if choice == 4:
        statement["excused"][rng.integers(len(statement["excused"]))][rng.integers(2)] = other
    if choice == 5:
        statement["pairs"][pair][2] = 10.0 ** rng.uniform(-6.0, 0.0)
    if choice == 6:
        statement["pairs"][pair][rng.integers(2)] = int(rng.integers(len(statement["parts"])))
    return Proof(statement, witness_of(times, counts, rows)).data


def clouds_and_contacts(proof: Proof, _: Proof, rng: np.random.Generator) -> bytes:
    """Move, regroup, enlarge or rename points of clouds, damage their parts, or change contact windows."""
    statement = copy.deepcopy(proof.statement)
    clouds = [each for each in statement["requirements"] if each["kind"] == "cloud"]
    if not clouds:
        return in_sections("contacts" if statement["contacts"] else "requirements")(proof, _, rng)
    cloud = clouds[rng.integers(len(clouds))]
    group, other = (cloud["inside"][rng.integers(len(cloud["inside"]))] for _ in range(2))
    vertices = statement["parts"][group[0]]["shape"]["vertices"]
    match rng.integers(8):
        case 0:
            point = group[1][rng.integers(len(group[1]))]
            point[rng.integers(3)] += 10.0 ** rng.uniform(-17.0, 0.0) * rng.choice((-1.0, 1.0))
        case 1:
            group[1], other[1] = other[1], group[1]
        case 2:
            group[0] = int(rng.integers(len(statement["parts"])))
        case 3:
            cloud["size"] *= 1.0 + 10.0 ** rng.uniform(-17.0, 0.5) * rng.choice((-0.5, 1.0))
        case 4:
            cloud["cubes"] = not cloud["cubes"]
        case 5:
            cloud["owner"] = str(rng.choice([part["owner"] for part in statement["parts"]]))
        case 6:
            del vertices[rng.integers(len(vertices))]
        case _:
            vertices[rng.integers(len(vertices))][rng.integers(3)] += 0.01 * rng.standard_normal()
    return Proof(statement, proof.witness).data


def hashes(proof: Proof, other: Proof, rng: np.random.Generator) -> bytes:
    """Exchange hash, statement or witness with another proof, or change the statement under its hash."""
    head, _, rest = proof.data.partition(b"\n")
    length = int(head.split()[1])
    statement, digest, witness = bytearray(rest[:length]), rest[length : length + 32], rest[length + 32 :]
    match rng.integers(5):
        case 0:
            digest = hashlib.sha256(json.dumps(other.statement).encode()).digest()
        case 1:
            statement = bytearray(json.dumps(other.statement).encode())
        case 2:
            witness = other.witness
        case 3:
            statement[rng.integers(length)] ^= 1 << int(rng.integers(8))
        case _:
            digest = bytes(rng.permutation(np.frombuffer(digest, np.uint8)))
    return b"proof/1 %d\n" % len(statement) + statement + digest + witness


def no_numbers(proof: Proof, _: Proof, rng: np.random.Generator) -> bytes:
    """Replace a number by NaN, an infinity, a huge number or another type."""
    times, counts, rows = witness_parts(proof)
    if rng.random() < 0.3 and times:
        times[rng.integers(len(times))] = float(
            rng.choice((math.nan, math.inf, -math.inf, 1e300, -0.0, 5e-324))
        )
        return Proof(proof.statement, witness_of(times, counts, rows)).data
    statement = copy.deepcopy(proof.statement)
    where = list(numbers(statement))
    container, key = where[rng.integers(len(where))]
    strange = (math.nan, math.inf, -math.inf, 1e300, 10**400, 9e11, 5e-324, -0.0, True, None, "1", [], {})
    container[key] = strange[rng.integers(len(strange))]
    return Proof(statement, proof.witness).data


def bits(data: bytes, rng: np.random.Generator) -> bytes:
    """Flip up to three bits."""
    flipped = bytearray(data)
    for place in rng.integers(len(data), size=rng.integers(1, 4)).tolist():
        flipped[place] ^= 1 << int(rng.integers(8))
    return bytes(flipped)


def file_bits(proof: Proof, _: Proof, rng: np.random.Generator) -> bytes:
    """Flip bits of the file, or cut its end."""
    data = proof.data
    return bits(data, rng) if rng.random() < 0.8 else data[: rng.integers(len(data))]


KINDS: Mapping[str, Mutation] = {
    "bits of the witness": lambda proof, _, rng: Proof(proof.statement, bits(proof.witness, rng)).data,
    "leaves and times: gaps, repeats, order": gaps,
    "directions": directions,
    "coefficients of motion and tracks": in_sections("motion", "drives"),
    "joints, limits, start": limits,
    "radii, vertices, places, presence": in_sections("parts", "changes", "contacts"),
    "pairs, clearances, excuses": pairs,
    "requirements and masses": in_sections("requirements"),
    "clouds and contact windows": clouds_and_contacts,
    "swapped hashes, statements, witnesses": hashes,
    "NaN, infinities, other types": no_numbers,
    "bits and length of the file": file_bits,
}


def outcome(checker: Checker, data: bytes, original: Document, path: Path) -> tuple[str, str]:
    """Return the outcome of a mutation, and the fault of the checker."""
    path.write_bytes(data)
    try:
        if checker.fault(path):
            return UNSHOWN, ""
    except checker.malformed:
        return MALFORMED, ""
    except Exception:
        return CRASH, traceback.format_exc()
    stated = Proof.read(path).statement
    if stated == original:
        return SAME, ""
    found = next(refuted(stated), "")
    return (FALSE, found) if found else (TRUE, "")


def accepted_fast(data: bytes) -> bool:
    """Return whether the fast kernel accepts a file."""
    try:
        return not MotionProof(data).fast_fault
    except FileFormatError:
        return False


def block(number: int, checker: Checker, sound: list[Proof], path: Path) -> dict[str, Any]:
    """Make and check the mutations of one block: number i has the random numbers of seed i."""
    begin, names = time.process_time(), list(KINDS)
    found, faults = {name: Counter[str]() for name in names}, list[str]()
    kernels = Counter[str]()
    for seed in range(number * BLOCK, (number + 1) * BLOCK):
        turn, place = divmod(seed, len(names))
        name, proof, other = names[place], *(sound[(turn + ahead) % len(sound)] for ahead in (0, 1))
        data = KINDS[name](proof, other, np.random.default_rng(seed))
        # A swap may give the other proof as a whole.
        result, fault = outcome(checker, data, proof.statement, path)
        found[name][result] += 1
        kernels[KERNELS[result in (SAME, TRUE, FALSE), accepted_fast(data)]] += 1
        faults += [f"{seed}: {fault}"] if fault else []
    seconds = round(time.process_time() - begin, 1)
    return {"block": number, "seconds": seconds, "found": found, "faults": faults, "kernels": kernels}


def finished(path: Path) -> list[dict[str, Any]]:
    """Return the stored blocks."""
    return json.loads(path.read_text()) if path.exists() else []


def page(blocks: list[dict[str, Any]]) -> str:
    """Return the table of outcomes."""
    columns, rows = (MALFORMED, UNSHOWN, SAME, TRUE, FALSE, CRASH), list[tuple[str, ...]]()
    counts = [each["found"] for each in blocks]
    totals = {name: sum((Counter(each.get(name, {})) for each in counts), Counter()) for name in KINDS}
    for name, found in {**totals, "all": sum(totals.values(), Counter[str]())}.items():
        rows.append((name, f"{found.total():,}", *(f"{found[column]:,}" for column in columns)))
    both = sum((Counter(each.get("kernels", {})) for each in blocks), Counter[str]())
    compared = table(
        ("both kernels", *KERNELS.values()),
        [(f"{both.total():,}", *(f"{both[name]:,}" for name in KERNELS.values()))],
    )
    return f"{table(('changed', 'mutations', *columns), rows)}\n\n{compared}"


def main() -> None:
    """Check the mutations that are not yet stored, and write the table."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("--count", type=int, default=100_000)
    options.add_argument("--kept", type=Path, default=KEPT)
    options.add_argument("--page", type=Path)
    given = options.parse_args()
    blocks = finished(given.kept)
    missing = sorted(set(range(math.ceil(given.count / BLOCK))) - {each["block"] for each in blocks})
    with tempfile.TemporaryDirectory() as place, loaded_checker() as checker:
        folder = Path(place)
        sound = proofs(folder) if missing else []
        for number in missing:
            blocks.append(block(number, checker, sound, folder / "x.proof"))
            print(blocks[-1], flush=True)
            given.kept.with_suffix(".draft").write_text("[\n" + ",\n".join(map(json.dumps, blocks)) + "\n]\n")
            os.replace(given.kept.with_suffix(".draft"), given.kept)
    text = page(blocks)
    print(text)
    if given.page is not None:
        write_section(given.page, "proof-mutations", text)


if __name__ == "__main__":
    main()
