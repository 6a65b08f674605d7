"""The checker refuses false statements, witnesses that leave gaps, and files of other kinds."""

import copy
import hashlib
import json
import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.files.proof.conftest import Checker, Document, Proof
from tests.files.proof.dense import of_kind
from trajopt.files.proof.proof import CHECKER

Change = Callable[[Document], object]


def changed(proof: Proof, change: Change) -> Proof:
    statement = copy.deepcopy(proof.statement)
    change(statement)
    return Proof(statement, proof.witness)


def part_of(statement: Document, owner: str) -> Document:
    return next(part for part in statement["parts"] if part["owner"] == owner)


def joint(statement: Document, field: str, value: Any) -> None:
    statement["joints"][1][field] = value


def torque(statement: Document) -> Document:
    (rule,) = of_kind(statement, "torque")
    return rule


FALSE: dict[str, tuple[Change, str]] = {
    "more clearance": (lambda s: [pair.__setitem__(2, 0.009) for pair in s["pairs"]], "keep 9 mm"),
    "a larger post": (lambda s: part_of(s, "post")["shape"].update(bottom=0.05, top=0.05), "post"),
    "a post in the way": (lambda s: part_of(s, "post")["place"].update(translation=[0.5, 0, 0.1]), "post"),
    "a pair left out": (lambda s: s["pairs"].__delitem__(0), ""),
    "an excuse removed": (lambda s: s["excused"].clear(), "neither a pair nor excused"),
    "an excuse of others": (
        lambda s: s["excused"][0].__setitem__(0, "nothing"),
        "neither a pair nor excused",
    ),
    "swapped parts": (
        lambda s: [pair.__setitem__(slice(0, 2), pair[1::-1]) for pair in s["pairs"]],
        "not shown",
    ),
    "a lower position": (lambda s: joint(s, "lower", -1.7), "position"),
    "a lower velocity": (lambda s: joint(s, "velocity", 2.9), "velocity"),
    "a lower acceleration": (lambda s: joint(s, "acceleration", 5.0), "acceleration"),
    "a lower jerk": (lambda s: joint(s, "jerk", 100.0), "jerk"),
    "a jump": (lambda s: s["motion"]["values"][2][40].__setitem__(0, 5.0), "shown"),
    "another start": (lambda s: s["ends"]["positions"].__setitem__(0, -1.0999), "start"),
    "a moving start": (lambda s: s["ends"]["velocities"].__setitem__(0, 1e-5), "velocity"),
    "a start that accelerates": (lambda s: s["ends"]["accelerations"].__setitem__(0, 1.0), "acceleration"),
    "a moving end": (lambda s: s["motion"]["values"][1][-1].__setitem__(0, 1e-4), ""),
    "another goal": (lambda s: s["requirements"][0]["ranges"].__setitem__(0, [1, 0.9002, 0.9003]), "joint1"),
    "a heavier link": (lambda s: torque(s)["loads"][1].__setitem__(1, 9.0), "torques"),
    "a link with more inertia": (lambda s: torque(s)["loads"][0][3].__setitem__(5, 2.0), "torques"),
    "a longer lever": (lambda s: torque(s)["loads"][1].__setitem__(2, [0.9, 0.0, 0.0]), "torques"),
    "heavier rotors": (lambda s: torque(s).update(rotors=[9.0, 9.0]), "torques"),
    "a weaker motor": (lambda s: torque(s).update(limits=[[0, 2.0], [1, 6.0]]), "torques"),
    "another factor": (lambda s: joint(s, "factor", -1.0), ""),
    "another axis": (lambda s: joint(s, "axis", [0.0, 0.0, -1.0]), ""),
    "a sliding joint": (lambda s: joint(s, "turns", False), ""),
}


@pytest.mark.parametrize("name", FALSE)
def test_a_false_statement_is_refused(name: str, tmp_path: Path, checker: Checker, planar: Proof) -> None:
    change, words = FALSE[name]
    path = changed(planar, change).write(tmp_path / "x.proof")
    try:
        fault = checker.fault(path)
    except checker.malformed as error:  # such as leaves of a pair that is no longer there
        fault = str(error)
    assert fault and words in fault


UNMET: dict[str, Change] = {
    "joint positions": lambda each: each["ranges"][0].__setitem__(slice(1, 3), [5.0, 6.0]),
    "axis alignment": lambda each: each.update(direction=[0.0, 1.0, 0.0]),
    "position in region": lambda each: each["members"][0][2].update(translation=[0.0, 0.0, -9.0]),
    "tool speed": lambda each: each.update(limit=0.3),
    "torque": lambda each: each["limits"].__setitem__(0, [0, 0.1]),
}


@pytest.mark.parametrize("place", range(8))
def test_an_unmet_requirement_is_refused(
    place: int, tmp_path: Path, checker: Checker, required: Proof
) -> None:
    statement = copy.deepcopy(required.statement)
    UNMET[statement["requirements"][place]["kind"]](statement["requirements"][place])
    fault = checker.fault(Proof(statement, required.witness).write(tmp_path / "x.proof"))
    assert "it is not shown" in fault


def test_a_tool_is_just_within_its_speed(tmp_path: Path, checker: Checker, required: Proof) -> None:
    """The bound is not so wide that any lower limit would do."""
    statement = copy.deepcopy(required.statement)
    (tool,) = of_kind(statement, "tool speed")
    tool["limit"] = 0.59
    assert "speed" in checker.fault(Proof(statement, required.witness).write(tmp_path / "x.proof"))


def leaves(proof: Proof) -> tuple[int, int, np.ndarray]:
    """Return where the numbers of leaves begin, where the leaves begin, and these, four numbers each."""
    (times,) = struct.unpack_from("<I", proof.witness)
    counts = 4 + 8 * times
    first = counts + 4 * len(proof.statement["pairs"])
    return counts, first, np.frombuffer(proof.witness[first:], "<u2").reshape(-1, 4).copy()


def with_leaves(proof: Proof, rows: np.ndarray) -> Proof:
    _, first, _ = leaves(proof)
    return Proof(proof.statement, proof.witness[:first] + rows.astype("<u2").tobytes())


def refused(checker: Checker, path: Path) -> bool:
    try:
        return bool(checker.fault(path))
    except checker.malformed:
        return True


def test_gaps_and_disorder_are_refused(tmp_path: Path, checker: Checker, planar: Proof) -> None:
    counts, first, rows = leaves(planar)
    late, twice, backwards = rows.copy(), rows.copy(), rows.copy()
    late[0, 0] = 1
    twice[1, 0] = twice[2, 0]
    backwards[1, 0] = 60_000
    for tampered in (late, twice, backwards, rows[:-1], np.vstack((rows, rows[-1:]))):
        with pytest.raises(checker.malformed):
            checker.fault(with_leaves(planar, tampered).write(tmp_path / "x.proof"))
    data = bytearray(planar.witness)
    moved = list(struct.unpack_from(f"<{(first - counts) // 4}I", data, counts))
    moved[0], moved[1] = moved[0] - 1, moved[1] + 1
    struct.pack_into(f"<{len(moved)}I", data, counts, *moved)
    with pytest.raises(checker.malformed):
        checker.fault(Proof(planar.statement, bytes(data)).write(tmp_path / "x.proof"))


def test_fewer_leaves_and_other_directions_are_refused(
    tmp_path: Path, checker: Checker, planar: Proof
) -> None:
    counts, first, rows = leaves(planar)
    data = bytearray(planar.witness)
    number = struct.unpack_from(f"<{(first - counts) // 4}I", data, counts)
    pair = int(np.argmax(number))
    begin = sum(number[:pair])
    # One leaf in the place of all those of the pair that needs most.
    struct.pack_into("<I", data, counts + 4 * pair, 1)
    kept = np.delete(rows, np.arange(begin + 1, begin + number[pair]), axis=0)
    single = Proof(planar.statement, bytes(data[:first]) + kept.tobytes())
    assert "not shown" in checker.fault(single.write(tmp_path / "x.proof"))
    for direction in ((0, 0, 0), (0, 0, 32_767), (1, 65_535, 1)):
        turned = rows.copy()
        turned[begin, 1:] = direction
        assert "not shown" in checker.fault(with_leaves(planar, turned).write(tmp_path / "x.proof"))


@pytest.mark.parametrize("time", [np.nan, np.inf, -1.0, 0.0, 1e9])
def test_times_outside_the_motion_are_refused(
    time: float, tmp_path: Path, checker: Checker, planar: Proof
) -> None:
    (times,) = struct.unpack_from("<I", planar.witness)
    assert times > 0
    data = bytearray(planar.witness)
    struct.pack_into("<d", data, 4, time)
    with pytest.raises(checker.malformed, match="within the motion"):
        checker.fault(Proof(planar.statement, bytes(data)).write(tmp_path / "x.proof"))


def test_truncated_files_are_refused(tmp_path: Path, checker: Checker, planar: Proof) -> None:
    data = planar.write(tmp_path / "x.proof").read_bytes()
    for length in (*range(0, 40), *range(40, len(data), 997), len(data) - 33, len(data) - 1):
        (tmp_path / "x.proof").write_bytes(data[:length])
        with pytest.raises(checker.malformed):
            checker.fault(tmp_path / "x.proof")
    (tmp_path / "x.proof").write_bytes(data + b"\0")
    with pytest.raises(checker.malformed, match="longer"):
        checker.fault(tmp_path / "x.proof")


def test_a_witness_of_another_statement_is_refused(tmp_path: Path, checker: Checker, planar: Proof) -> None:
    data = planar.write(tmp_path / "x.proof").read_bytes()
    assert b'"planar fold"' in data
    (tmp_path / "x.proof").write_bytes(data.replace(b'"planar fold"', b'"planar Fold"'))
    with pytest.raises(checker.malformed, match="SHA-256"):
        checker.fault(tmp_path / "x.proof")


def goal(statement: Document) -> Document:
    return statement["requirements"][0]


BAD: dict[str, Change] = {
    "the world as a joint": lambda s: goal(s)["ranges"][0].__setitem__(0, 0),
    "a range without an end": lambda s: goal(s)["ranges"][0].pop(),
    "unknown field": lambda s: s.update(note="trust me"),
    "missing field": lambda s: s.pop("excused"),
    "unknown requirement": lambda s: s["requirements"].append({"kind": "fine"}),
    "unhashable kind": lambda s: s["requirements"].append({"kind": []}),
    "infinite": lambda s: s.update(excess=float("inf")),
    "not a number": lambda s: s["motion"]["values"][0][3].__setitem__(0, float("nan")),
    "huge": lambda s: s["motion"]["values"][0][3].__setitem__(0, 10**400),
    "true": lambda s: s["motion"]["values"][0][3].__setitem__(0, True),
    "text": lambda s: s["motion"]["times"].__setitem__(1, "0.1"),
    "times back": lambda s: s["motion"]["times"].__setitem__(2, 0.0),
    "a late beginning": lambda s: s["motion"]["times"].__setitem__(0, 1e-6),
    "ragged": lambda s: s["motion"]["values"][0][3].pop(),
    "no motion": lambda s: s.update(motion=None),
    "negative radius": lambda s: part_of(s, "post")["shape"].update(bottom=-0.04),
    "no vertex": lambda s: s["parts"].append(
        {**s["parts"][0], "shape": {"kind": "hull", "vertices": [], "radius": 1}}
    ),
    "no rotation": lambda s: s["parts"][0]["place"].update(rotation=[0, 0, 0, 0]),
    "no axis": lambda s: joint(s, "axis", [0, 0, 0]),
    "parent later": lambda s: s["joints"][0]["place"].update(joint=2),
    "its own parent": lambda s: s["joints"][0]["place"].update(joint=1),
    "negative clearance": lambda s: s["pairs"][0].__setitem__(2, -1.0),
    "no such part": lambda s: s["pairs"][0].__setitem__(0, 10**6),
    "part of the world before": lambda s: s["pairs"][0].__setitem__(0, -1),
    "a fraction of a part": lambda s: s["pairs"][0].__setitem__(0, 1.0),
    "an excess that is not small": lambda s: s.update(excess=0.1),
    "an excuse without a reason": lambda s: s["excused"][0].__setitem__(2, " "),
    "an obstacle that is named as a link": lambda s: part_of(s, "post").update(owner="link2"),
    "an object that is there at two times": lambda s: s["changes"].extend(
        [["post", 0.0, 0.5, [0, 0, 0]], ["post", 0.5, 9.0, [0, 0, 0]]]
    ),
    "control characters": lambda s: s.update(title="x\x1b[2Jproven"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_statements_are_refused_in_a_sentence(
    name: str, tmp_path: Path, checker: Checker, planar: Proof
) -> None:
    with pytest.raises(checker.malformed):
        checker.fault(changed(planar, BAD[name]).write(tmp_path / "x.proof"))


DISCLOSED: dict[str, tuple[Change, str]] = {
    "a loose end": (lambda s: s["ends"].update(speed=100.0), "and ends at rest; speeds are to within 100"),
    "a loose start": (lambda s: s["ends"].update(tolerance=9.0), "has the stated start, to within 9"),
    "a limit that is not there": (
        lambda s: joint(s, "velocity", None),
        "2 joints keep their limits: 2 lower, 2 upper, 1 velocity, 2 acceleration, 2 jerk",
    ),
    "a frame on another joint": (
        lambda s: s["requirements"].append(
            {
                "kind": "tool speed", "frame": "tool", "limit": 9,
                "place": {"joint": 0, "rotation": [1, 0, 0, 0], "translation": [0, 0, 0]},
            }
        ),
        "the speed of tool on the world is",
    ),
    "an axis": (
        lambda s: s["requirements"].append(
            {
                "kind": "axis alignment", "frame": "tool", "joint": 2, "axis": [0, 0, 1], "reference": 0,
                "direction": [0, 0, 1], "tolerance": 0.1, "always": True,
            }
        ),
        "axis (0, 0, 1) of tool on joint2 along (0, 0, 1), within 0.1 rad",
    ),
    "coordinates of the motion": (lambda s: None, "all that joint1, joint2 can move, but"),
    "masses": (lambda s: torque(s)["loads"].clear(), "torques of 0 kg are at most"),
}  # fmt: skip


@pytest.mark.parametrize("name", DISCLOSED)
def test_the_words_disclose_what_makes_a_statement_weak(
    name: str, tmp_path: Path, checker: Checker, planar: Proof
) -> None:
    change, words = DISCLOSED[name]
    said, fault = checker.examined(changed(planar, change).write(tmp_path / "x.proof"))
    assert not fault and words in said


@pytest.mark.parametrize(
    "statement",
    [
        b"",
        b"{}",
        b"[]",
        b"null",
        b"[" * 100_000,
        b'{"a":1,"a":1}',
        b"\xff\xfe",
        b'{"excess":NaN}',
        b"1" * 5000,
    ],
)
def test_other_json_is_refused(statement: bytes, tmp_path: Path, checker: Checker) -> None:
    digest = hashlib.sha256(statement).digest()
    (tmp_path / "x.proof").write_bytes(b"proof/1 %d\n" % len(statement) + statement + digest + bytes(4))
    with pytest.raises(checker.malformed):
        checker.fault(tmp_path / "x.proof")


def test_huge_and_compressed_files_are_not_read(tmp_path: Path, checker: Checker) -> None:
    with (tmp_path / "huge.proof").open("wb") as file:
        file.write(b"proof/1 10\n")
        file.truncate(2**40)
    with pytest.raises(checker.malformed, match="longer"):
        checker.fault(tmp_path / "huge.proof")
    for head in (
        b"PK\x03\x04",
        b"\x1f\x8b",
        b"proof/2 10\n",
        b"proof/1 -1\n",
        b"proof/1 1e9\n",
        b"proof/1 9\n",
    ):
        (tmp_path / "x.proof").write_bytes(head + bytes(100))
        with pytest.raises(checker.malformed):
            checker.fault(tmp_path / "x.proof")
    with pytest.raises(checker.malformed):
        checker.fault(tmp_path)


@pytest.mark.parametrize("arguments", [[], ["missing.proof"], ["a", "b"]])
def test_bad_input_is_a_sentence_and_exit_status_2(arguments: list[str], tmp_path: Path) -> None:
    command = [sys.executable, "-I", str(CHECKER), *arguments]
    run = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert run.returncode == 2 and run.stdout == ""
    assert len(run.stderr.splitlines()) == 1


def one_joint(gap: float, speed: float = 0.0) -> Document:
    """A ball at the end of an arm of 1 m, at rest or turning, beside a box at a gap along x."""
    place = {"joint": 0, "rotation": [1, 0, 0, 0], "translation": [0, 0, 0]}
    corners = [[1.5 + gap + x, y, z] for x in (0.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]
    rate = [[speed], [speed]]
    return {
        "title": "touch",
        "drives": [], "changes": [], "contacts": [],
        "motion": {"coordinates": ["j"], "times": [0, 1], "values": [[[0], [speed]], rate, [[0], [0]]]},
        "joints": [
            {
                "name": "j", "place": place, "turns": True, "axis": [0, 0, 1], "coordinate": 0, "factor": 1,
                "offset": 0, **dict.fromkeys(("lower", "upper", "velocity", "acceleration", "jerk")),
            }
        ],
        "ends": {
            "positions": [0], "velocities": [speed], "accelerations": [0], "tolerance": 1e-9, "speed": 1e-9,
            "rests": False,
        },
        "excess": 0,
        "parts": [
            {
                "owner": "ball", "place": {**place, "joint": 1, "translation": [1, 0, 0]},
                "shape": {"kind": "hull", "vertices": [[0, 0, 0]], "radius": 0.5},
            },
            {"owner": "box", "place": place, "shape": {"kind": "hull", "vertices": corners, "radius": 0}},
        ],
        "pairs": [[0, 1, 0]], "excused": [], "requirements": [], "judged": [],
    }  # fmt: skip


WHOLE = struct.pack("<IIHhhh", 0, 1, 0, 1, 0, 0)
"""One leaf of the whole motion, along x."""


def test_a_touch_is_refused_and_a_nanometre_is_enough(tmp_path: Path, checker: Checker) -> None:
    assert checker.fault(Proof(one_joint(1e-9), WHOLE).write(tmp_path / "x.proof")) == ""
    for gap in (0.0, -1e-15, -1e-9, -0.1):
        fault = checker.fault(Proof(one_joint(gap), WHOLE).write(tmp_path / "x.proof"))
        assert fault == "leaf 0: it is not shown that ball and box keep 0 mm from 0 to 1 s"


def test_violations_between_the_ends_count(tmp_path: Path, checker: Checker) -> None:
    """A ball that turns by a full turn is where it was at both ends, and half of it away from the box."""
    statement = one_joint(0.1, speed=2.0 * np.pi)
    assert "not shown" in checker.fault(Proof(statement, WHOLE).write(tmp_path / "x.proof"))
    # Turned by a little, the ball's arc is off its chord by up to w^2 r / 8, with r of the ball's far side.
    for speed, proven in ((0.7, True), (0.75, False)):
        statement = one_joint(0.1, speed=speed)
        assert (checker.fault(Proof(statement, WHOLE).write(tmp_path / "x.proof")) == "") == proven


def test_no_mutation_of_the_witness_crashes_the_checker(
    tmp_path: Path, checker: Checker, planar: Proof
) -> None:
    """The statement stays true; the checker answers or refuses, whichever bits are flipped."""
    rng = np.random.default_rng(7)
    outcomes = {True: 0, False: 0}
    for _ in range(60):
        data = bytearray(planar.witness)
        for place in rng.integers(len(data), size=rng.integers(1, 4)):
            data[place] ^= 1 << int(rng.integers(8))
        outcomes[refused(checker, Proof(planar.statement, bytes(data)).write(tmp_path / "x.proof"))] += 1
    assert min(outcomes.values()) > 0


def test_the_json_of_a_statement_keeps_every_double(planar: Proof) -> None:
    assert json.loads(json.dumps(planar.statement)) == planar.statement
