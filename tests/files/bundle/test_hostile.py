"""Bundles made to do harm, or damaged: refused by a typed error, soon, in little memory."""

import json
import random
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from trajopt.files.bundle import read_bundle
from trajopt.planning import Result
from trajopt.values.errors import FileFormatError, TrajoptError

from .conftest import members_of, write_members
from .hostile import DOCUMENTS, Members, bomb, files, liar, of_sizes


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
def test_files_that_are_not_bundles_are_refused(what: str, members: Members, tmp_path: Path) -> None:
    path = tmp_path / "hostile.trajopt"
    files()[what](path, members)
    _refused(path)


@pytest.mark.parametrize("what", DOCUMENTS)
def test_documents_with_forbidden_contents_are_refused(what: str, members: Members, tmp_path: Path) -> None:
    changed = dict(members)
    DOCUMENTS[what](changed)
    _refused(write_members(tmp_path / "hostile.trajopt", changed))


@pytest.mark.slow
@pytest.mark.parametrize("what", of_sizes())
def test_more_than_there_is_any_need_for_is_refused(what: str, members: Members, tmp_path: Path) -> None:
    changed = dict(members)
    of_sizes()[what](changed)
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
    for name, what in (("bomb", bomb), ("liar", liar)):
        what(tmp_path / f"{name}.trajopt", members)
    deep = {**members, "problem.json": b"[" * (2**24 - 1)}
    write_members(tmp_path / "deep.trajopt", deep)
    wide = {**members, "problem.json": b'{"map": {"a": [' + b"[]," * (5 * 10**6) + b"[]]}}"}
    write_members(tmp_path / "wide.trajopt", wide)
    code = (
        "import re, sys\n"
        "from trajopt.files.bundle import read_bundle\n"
        "from trajopt.values.errors import FileFormatError\n"
        "for path in sys.argv[1:]:\n"
        "    try:\n"
        "        read_bundle(path)\n"
        "    except FileFormatError:\n"
        "        print('refused')\n"
        # Of this process alone: what the system says of its resources counts its parent's memory too.
        "print(re.search(r'VmHWM:\\s+(\\d+)', open('/proc/self/status').read())[1])"
    )
    paths = [str(tmp_path / f"{name}.trajopt") for name in ("bomb", "liar", "deep", "wide")]
    ended = subprocess.run(
        [sys.executable, "-c", code, *paths], capture_output=True, text=True, check=True, timeout=120
    )
    *refused, kilobytes = ended.stdout.split()
    assert refused == ["refused"] * len(paths), ended.stdout
    assert int(kilobytes) < 2**20
