"""Bundles made to do harm, or damaged, by what is wrong with them."""

import io
import json
import random
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from .conftest import write_members

Members = dict[str, bytes]


def _zip_of(path: Path, items: list[tuple[str, bytes]], kind: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", kind) as file:
        for name, data in items:
            file.writestr(name, data)
    return path


def bomb(path: Path, members: Members) -> None:
    """A gigabyte of zeros, in a megabyte."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in members.items():
            file.writestr(name, data)
        with file.open("arrays/9999.npy", "w", force_zip64=True) as member:
            for _ in range(64):
                member.write(bytes(2**24))


def liar(path: Path, members: Members) -> None:
    """A member that says that it holds less than it does."""
    data = bytes(2**28)
    packed = zlib.compress(data, 9)[2:-4]
    _zip_of(path, [*members.items(), ("arrays/9999.npy", packed)], zipfile.ZIP_STORED)
    raw = bytearray(path.read_bytes())
    for mark, offset in ((b"PK\x03\x04", 8), (b"PK\x01\x02", 10)):
        at = raw.rfind(
            mark, 0, raw.rfind(b"arrays/9999.npy") if mark == b"PK\x01\x02" else raw.find(b"arrays/9999.npy")
        )
        raw[at + offset : at + offset + 2] = (8).to_bytes(2, "little")
    path.write_bytes(bytes(raw))


def _array(shape: tuple[int, ...], kind: str, data: bytes) -> bytes:
    stream = io.BytesIO()
    header = f"{{'descr': {kind!r}, 'fortran_order': False, 'shape': {shape}, }}"
    padded = header.ljust(117) + "\n"
    stream.write(b"\x93NUMPY\x01\x00" + len(padded).to_bytes(2, "little") + padded.encode() + data)
    return stream.getvalue()


def _without_problem(members: Members) -> None:
    del members["problem.json"]


def _with_flag(data: bytes, flag: int) -> bytes:
    """Set a flag of the first member in the directory of a zip."""
    place = data.index(b"PK\x01\x02") + 8
    return data[:place] + bytes([data[place] | flag]) + data[place + 1 :]


def files() -> dict[str, Callable[[Path, Members], object]]:
    """Files that are no bundles, by what is wrong with them."""
    names = (
        "../out",
        "/etc/passwd",
        "a/../../b",
        "a/b/c",
        "C:\\x",
        "",
        "a//b",
        "x" * 300,
        ".hidden",
        "a b",
        "é",
    )
    made: dict[str, Callable[[Path, Members], object]] = {
        f"a member named {name!r}": lambda path, members, name=name: _zip_of(
            path, [*members.items(), (name, b"x")]
        )
        for name in names
        if name
    }
    others: dict[str, Callable[[Path, Members], object]] = {
        "nothing": lambda path, _: path.write_bytes(b""),
        "noise": lambda path, _: path.write_bytes(random.Random(1).randbytes(4096)),
        "an empty zip": lambda path, _: _zip_of(path, []),
        "half a file": lambda path, members: (
            write_members(path, members),
            path.write_bytes(path.read_bytes()[: path.stat().st_size // 2]),
        ),
        "a bomb": bomb,
        "a member larger than it says": liar,
        "a zip in a zip": lambda path, members: _zip_of(
            path, [("inner.zip", write_members(path, members).read_bytes())]
        ),
        "a member twice": lambda path, members: _zip_of(path, [*members.items(), ("problem.json", b"{}")]),
        "a member said to be encrypted": lambda path, members: (
            write_members(path, members),
            path.write_bytes(_with_flag(path.read_bytes(), 0x40)),
        ),
        "packed by bzip2": lambda path, members: _zip_of(path, [*members.items()], zipfile.ZIP_BZIP2),
        "packed by lzma": lambda path, members: _zip_of(path, [*members.items()], zipfile.ZIP_LZMA),
        "too many members": lambda path, members: _zip_of(
            path,
            [*members.items(), *((f"arrays/{k}.npy", b"") for k in range(10**4, 3 * 10**4 + 1))],
            zipfile.ZIP_STORED,
        ),
        "a member that nobody named": lambda path, members: _zip_of(
            path, [*members.items(), ("extra", b"x")]
        ),
        "a member that was changed": lambda path, members: _zip_of(
            path, [*({**members, "problem.json": members["problem.json"] + b" "}).items()]
        ),
    }
    return {**made, **others}


Change = Callable[[Members], None]


def text(name: str, data: str) -> Change:
    """Put something else in the place of a document."""
    return lambda members: members.update({name: data.encode()})


def swap(name: str, old: str, new: str) -> Change:
    """Change a part of a document."""

    def change(members: Members) -> None:
        assert old.encode() in members[name], (name, old)
        members[name] = members[name].replace(old.encode(), new.encode(), 1)

    return change


def array(data: bytes) -> Change:
    """Put something else in the place of an array."""
    return lambda members: members.update({next(n for n in members if n.startswith("arrays/")): data})


def of_json() -> dict[str, Change]:
    """Documents that are none, or of no value."""
    return {
        "no JSON": text("problem.json", "{"),
        "a list": text("problem.json", "[]"),
        "no text": lambda members: members.update({"problem.json": b"\xff\xfe\x00"}),
        "deep": text("problem.json", '{"a":' * 10**5),
        "deep lists": text("problem.json", "[" * 10**6),
        "twenty megabytes": text("problem.json", '{"a": "' + "x" * (2 * 10**7) + '"}'),
        "not a number": swap("problem.json", '"joint1"', "NaN"),
        "infinite": text("problem.json", '{"kind": Infinity}'),
        "a kind of Python's": text("problem.json", '{"kind": "os.system", "command": "true"}'),
        "a kind with a path": text("problem.json", '{"kind": "trajopt.cli.main"}'),
        "a kind that is a number": text("problem.json", '{"kind": 3}'),
        "no kind": text("problem.json", '{"reduce": ["os.system", ["true"]]}'),
        "another value": text("problem.json", '{"kind": "Sphere", "radius": 0.1}'),
        "a field too many": text("problem.json", '{"kind": "Sphere", "radius": 0.1, "colour": 3}'),
        "a field too few": text("problem.json", '{"kind": "Box", "x": 0.1}'),
        "a robot of nothing": text("problem.json", '{"kind": "Robot"}'),
        "no problem": _without_problem,
    }


def of_contents() -> dict[str, Change]:
    """Documents that say what they must not."""
    return {
        "another format": swap("bundle.json", "trajopt bundle", "tarball"),
        "no date": swap("bundle.json", '"made": "', '"made": "x'),
        "holds nothing": swap("bundle.json", '"PLAN"', '"SCENE"'),
        "a version that is a text": swap("bundle.json", '"version": 1', '"version": "1"'),
        "versions are a list": lambda members: members.update(
            {"bundle.json": json.dumps({**json.loads(members["bundle.json"]), "versions": [1]}).encode()}
        ),
        "a motion of other joints": swap("motion.json", '"joint1"', '"joint9"'),
        "a motion that is a ball": text("motion.json", '{"trajectory": {"kind": "Sphere", "radius": 1.0}}'),
        "a motion in the past": text(
            "motion.json",
            '{"trajectory": {"kind": "Trajectory", "joint_names": ["joint1", "joint2"], '
            '"times": {"array": [0, -1], "type": "float64"}, '
            '"positions": {"array": [[0, 0], [1, 1]], "type": "float64"}}}',
        ),
        "a method that is a list": text("arguments.json", '{"method": []}'),
        "seeds that are one array": text(
            "arguments.json", '{"seeds": {"array": [[1, 2]], "type": "float64"}}'
        ),
        "a seed that is a ball": text("arguments.json", '{"seeds": [{"kind": "Sphere", "radius": 1.0}]}'),
        "a random state that is a list": text("arguments.json", '{"random": [1]}'),
        "a budget that is a ball": text("arguments.json", '{"budget": {"kind": "Sphere", "radius": 1.0}}'),
        "a clock of one's own": text(
            "arguments.json", '{"budget": {"kind": "Budget", "clock": "os.system"}}'
        ),
    }


def of_arrays() -> dict[str, Change]:
    """Arrays that are none."""
    huge = 10**9
    return {
        "an array of objects": array(_array((1,), "|O", b"cos\nsystem\n(S'true'\ntR.")),
        "an array of text": array(_array((1,), "<U4", b"x" * 16)),
        "an array that says more than it holds": array(_array((huge, huge), "<f8", b"x" * 16)),
        "an array that says less than it holds": array(_array((1,), "<f8", b"x" * 16)),
        "an array of negative size": array(_array((-1,), "<f8", b"x" * 16)),
        "an array with code in its head": array(_array((1,), "<f8'+__import__('os').getcwd()+'", b"x" * 8)),
        "an array with a head of brackets": array(
            b"\x93NUMPY\x01\x00" + (500).to_bytes(2, "little") + b"[" * 500
        ),
        "an array of another version": array(b"\x93NUMPY\x02\x00" + b"x" * 64),
        "no array": array(b"x"),
        "an array of another shape": array(_array((3,), "<f8", bytes(24))),
    }


def of_values() -> dict[str, Change]:
    """Values that are none."""
    return {
        "a gravity that is a text": swap("problem.json", '"gravity"', '"gravitation"'),
        "a parent that comes later": swap("problem.json", '"parent": 0', '"parent": 7'),
        "a parent that is negative": swap("problem.json", '"parent": 0', '"parent": -1'),
        "a joint of no kind": swap("problem.json", '"JointModelRZ"', '"JointModelFreeFlyer"'),
        "a ball of negative size": swap("problem.json", '"radius": 0.1', '"radius": -0.1'),
        "a ball of infinite size": swap("problem.json", '"radius": 0.1', '"radius": {"number": "inf"}'),
        "a ball the size of a text": swap("problem.json", '"radius": 0.1', '"radius": "0.1"'),
        "a ball of many digits": swap("problem.json", '"radius": 0.1', f'"radius": 1{"0" * 400}'),
        "a number of very many digits": swap("problem.json", '"radius": 0.1', f'"radius": {"1" * 10**5}'),
        "faces between no vertices": text(
            "problem.json",
            '{"kind": "Convex", "vertices": {"array": [[0,0,0],[1,0,0],[0,1,0],[0,0,1]], "type": "float64"}, '
            '"faces": {"array": [[0,1,99]], "type": "int32"}}',
        ),
        "faces of negative vertices": text(
            "problem.json",
            '{"kind": "Mesh", "vertices": {"array": [[0,0,0],[1,0,0],[0,1,0],[0,0,1]], "type": "float64"}, '
            '"faces": {"array": [[0,1,-3]], "type": "int32"}}',
        ),
        "a group without joints": swap("problem.json", '"group": "arm"', '"group": "leg"'),
        "a start of a hundred joints": swap("problem.json", '"knots": 24', '"knots": 10000000'),
        "a set of lists": text("problem.json", '{"set": [{"map": {}}]}'),
        "pairs that are three": text("problem.json", '{"pairs": [[1, 2, 3]]}'),
        "an array of nothing": text("problem.json", '{"array": [[1], [2, 3]], "type": "float64"}'),
        "an array of a kind": text("problem.json", '{"array": [1], "type": "object"}'),
        "an array that is nowhere": text("problem.json", '{"array": "arrays/999.npy"}'),
        "an array that is a document": text("problem.json", '{"array": "bundle.json"}'),
    }


def _problem_of(value: object) -> Change:
    """Put a value in the place of the problem."""
    return lambda members: members.update({"problem.json": json.dumps(value).encode()})


def _chain(members: Members, joints: int) -> None:
    """A robot that is a chain of many joints: what it takes grows with the square of its length."""
    document = json.loads(members["problem.json"])
    tree = document["scene"]["robot"]["model"]["kinematics"]
    members["arrays/7777.npy"] = _array((4, 4), "<f8", np.eye(4).tobytes())
    first = {**tree["joints"][0], "placement": {"array": "arrays/7777.npy"}}
    tree["joints"] = [{**first, "name": f"j{number}", "parent": number} for number in range(joints)]
    members["problem.json"] = json.dumps(document).encode()


def _objects(members: Members, count: int) -> None:
    """Many objects of a kind that is none."""
    document = json.loads(members["problem.json"])
    objects = document["scene"]["objects"]["map"]
    ball = objects.pop("ball")
    wrong = json.loads(json.dumps(ball).replace("0.1", "-0.1"))
    objects.update({f"ball {number}": ball for number in range(count)}, wrong=wrong)
    members["problem.json"] = json.dumps(document).encode()


def _long_array(members: Members) -> None:
    """A start of as many numbers as an array may have."""
    members["arrays/7777.npy"] = _array((8 * 10**6,), "<f8", bytes(64 * 10**6))
    document = json.loads(members["problem.json"])
    document["start"] = {"array": "arrays/7777.npy"}
    members["problem.json"] = json.dumps(document).encode()


def _long_motion(members: Members) -> None:
    """A motion whose times, four million of them, are all the same."""
    members["arrays/7777.npy"] = _array((4 * 10**6,), "<f8", bytes(32 * 10**6))
    members["arrays/7778.npy"] = _array((4 * 10**6, 2), "<f8", bytes(64 * 10**6))
    kept = {"kind": "Trajectory", "joint_names": ["joint1", "joint2"]}
    kept |= {"times": {"array": "arrays/7777.npy"}, "positions": {"array": "arrays/7778.npy"}}
    members["motion.json"] = json.dumps({"trajectory": kept}).encode()


def _often(members: Members) -> None:
    """One array of many numbers in many places."""
    members["arrays/7777.npy"] = _array((2 * 10**6,), "<f8", bytes(16 * 10**6))
    members["problem.json"] = json.dumps([{"array": "arrays/7777.npy"}] * 20_000).encode()


def _large_shape(kind: str, vertices: int, faces: int) -> Change:
    """A shape of many vertices and faces."""

    def change(members: Members) -> None:
        members["arrays/7777.npy"] = _array((vertices, 3), "<f8", bytes(24 * vertices))
        members["arrays/7778.npy"] = _array((faces, 3), "<i4", bytes(12 * faces))
        shape = {
            "kind": kind,
            "vertices": {"array": "arrays/7777.npy"},
            "faces": {"array": "arrays/7778.npy"},
        }
        members["problem.json"] = json.dumps(shape).encode()

    return change


def of_sizes() -> dict[str, Change]:
    """More than there is any need for, within what a zip may hold."""
    return {
        "half a million values": _problem_of({"map": {"a": [0] * 499_990}}),
        "half a million sets": _problem_of([{"set": list[int]()}] * 250_000),
        "a quarter of a million pairs": _problem_of({"pairs": [[number, 0] for number in range(160_000)]}),
        "a name of ten million letters": swap(
            "problem.json", '"past a ball"', f'"{"x" * 10**7}", "knots": 1'
        ),
        "keys of a million letters": _problem_of(
            {"kind": "Sphere", **{"k" * 10**6 + str(n): 1 for n in range(9)}}
        ),
        "a chain of fifteen thousand joints": lambda members: _chain(members, 15_000),
        "three thousand objects, and one that is none": lambda members: _objects(members, 3_000),
        "a start of eight million numbers": _long_array,
        "a motion of four million moments": _long_motion,
        "one array of 240 MB": lambda members: members.update(
            {"arrays/7777.npy": _array((30 * 10**6,), "<f8", bytes(240 * 10**6))}
        ),
        "an array that is named twenty thousand times": _often,
        "a mesh of five million faces": _large_shape("Mesh", 1_000, 5 * 10**6),
        "a hull of two million vertices": _large_shape("Convex", 2 * 10**6, 4),
        "a hull of many vertices and faces": _large_shape("Convex", 2 * 10**6, 5 * 10**6),
        "an array of fifty dimensions": array(_array((1,) * 50, "<f8", bytes(8))),
        "an array of as many numbers as there are": array(_array((2**62, 4), "<f8", bytes(64))),
        "numbers of very many digits": _problem_of({"map": {str(n): int("9" * 4_000) for n in range(1_000)}}),
        "an exponent without end": text("problem.json", '{"kind": "Sphere", "radius": 1e999999999}'),
        "a hundred thousand keys": _problem_of({"kind": "Box", **{f"x{n}": 1 for n in range(100_000)}}),
        "many seeds": text("arguments.json", '{"seeds": [' + "[]," * 200_000 + "[]]}"),
        "an answer that is deep": text("answer.json", '{"a":' * 2_000 + "1" + "}" * 2_000),
        "an answer of many values": text("answer.json", '{"a": [' + "0," * 600_000 + "0]}"),
    }


DOCUMENTS = of_json() | of_contents() | of_arrays() | of_values()
"""Changes to the members of a bundle, by what is wrong then."""
