"""Bundles made to do harm, or damaged: refused by a typed error, soon, in little memory."""

import io
import json
import random
import subprocess
import sys
import zipfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from trajopt.bundle import read_bundle
from trajopt.errors import FileFormatError, TrajoptError
from trajopt.planning import Result

from .conftest import members_of, write_members

Members = dict[str, bytes]


def _zip_of(path: Path, items: list[tuple[str, bytes]], kind: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", kind) as file:
        for name, data in items:
            file.writestr(name, data)
    return path


def _bomb(path: Path, members: Members) -> None:
    """A gigabyte of zeros, in a megabyte."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in members.items():
            file.writestr(name, data)
        with file.open("arrays/9999.npy", "w", force_zip64=True) as member:
            for _ in range(64):
                member.write(bytes(2**24))


def _liar(path: Path, members: Members) -> None:
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
        "a bomb": _bomb,
        "a member larger than it says": _liar,
        "a zip in a zip": lambda path, members: _zip_of(
            path, [("inner.zip", write_members(path, members).read_bytes())]
        ),
        "a member twice": lambda path, members: _zip_of(path, [*members.items(), ("problem.json", b"{}")]),
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
        "a kind with a path": text("problem.json", '{"kind": "trajopt.cli.app.main"}'),
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


DOCUMENTS = of_json() | of_contents() | of_arrays() | of_values()
"""Changes to the members of a bundle, by what is wrong then."""


@pytest.fixture(scope="module")
def members(tmp_path_factory: pytest.TempPathFactory, solved: Result) -> Members:
    path = tmp_path_factory.mktemp("kept") / "kept.trajopt"
    solved.save(path)
    return members_of(path)


def _refused(path: Path) -> None:
    with pytest.raises(FileFormatError):
        read_bundle(path)


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize("what", files())
def test_files_that_are_no_bundles_are_refused(what: str, members: Members, tmp_path: Path) -> None:
    path = tmp_path / "hostile.trajopt"
    files()[what](path, members)
    _refused(path)


@pytest.mark.parametrize("what", DOCUMENTS)
def test_documents_that_say_what_they_must_not_are_refused(
    what: str, members: Members, tmp_path: Path
) -> None:
    changed = dict(members)
    DOCUMENTS[what](changed)
    _refused(write_members(tmp_path / "hostile.trajopt", changed))


JUNK: tuple[Any, ...] = (
    *(None, True, -1, 0, 1e308, 10**30, "", "joint1", "x" * 1000, [], {}, [[[]]]),
    *({"number": "nan"}, {"number": "inf"}, {"array": [], "type": "float64"}, {"map": {}}, {"set": []}),
    *({"kind": "Sphere", "radius": 1.0}, {"kind": "Plane"}, {"array": [1e300] * 7, "type": "float64"}),
)


def _places(value: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Return the way to every value of a document."""
    yield place
    if isinstance(value, dict | list):
        inside: Any = value.items() if isinstance(value, dict) else enumerate(value)  # type: ignore[reportUnknownMemberType]
        for key, each in inside:
            yield from _places(each, (*place, key))


@pytest.mark.parametrize("seed", range(6))
def test_anything_else_in_any_place_is_refused_or_judged(seed: int, members: Members, tmp_path: Path) -> None:
    """A hundred documents with one value replaced: no other error than one that says what is wrong."""
    rng = random.Random(seed)
    for _ in range(25):
        document = json.loads(members["problem.json"])
        *way, last = rng.choice([place for place in _places(document) if place])
        inner = document
        for key in way:
            inner = inner[key]
        inner[last] = rng.choice(JUNK)
        changed = {**members, "problem.json": json.dumps(document).encode()}
        try:
            read_bundle(write_members(tmp_path / "hostile.trajopt", changed)).judged()
        except TrajoptError as error:
            assert str(error)


def test_bombs_take_little_memory(members: Members, tmp_path: Path) -> None:
    """A process that reads them stays below a gigabyte."""
    for name, what in (("bomb", _bomb), ("liar", _liar)):
        what(tmp_path / f"{name}.trajopt", members)
    deep = {**members, "problem.json": b"[" * (2**24 - 1)}
    write_members(tmp_path / "deep.trajopt", deep)
    wide = {**members, "problem.json": b'{"map": {"a": [' + b"[]," * (5 * 10**6) + b"[]]}}"}
    write_members(tmp_path / "wide.trajopt", wide)
    code = (
        "import resource, sys\n"
        "from trajopt.bundle import read_bundle\n"
        "from trajopt.errors import FileFormatError\n"
        "for path in sys.argv[1:]:\n"
        "    try:\n"
        "        read_bundle(path)\n"
        "    except FileFormatError:\n"
        "        print('refused')\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
    )
    paths = [str(tmp_path / f"{name}.trajopt") for name in ("bomb", "liar", "deep", "wide")]
    ended = subprocess.run(
        [sys.executable, "-c", code, *paths], capture_output=True, text=True, check=True, timeout=120
    )
    *refused, kilobytes = ended.stdout.split()
    assert refused == ["refused"] * len(paths), ended.stdout
    assert int(kilobytes) < 2**20
