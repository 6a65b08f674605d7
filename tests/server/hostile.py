"""A hundred requests that no honest client sends: what each is, and how it goes out."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

HEAD = "{method} {path} HTTP/1.1\r\nHost: {host}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n\r\n"
HUGE = 3 * 2**20
"""More than the body that the tests' server takes."""
GOAL = {"joint_positions": {"positions": {"joint1": 0.4, "joint2": 0.3}}}


@dataclass(frozen=True)
class Hostile:
    """A request.

    Attributes:
        name: What is wrong with it.
        make: From the session's id, the bytes that go out.
        cut: Whether the server may cut it off without a word.
    """

    name: str
    make: Callable[[str], bytes]
    cut: bool = False


def raw(
    path: str, body: bytes, *, method: str = "POST", kind: str = "application/json", host: str = "localhost",
    length: int | None = None,
) -> bytes:  # fmt: skip
    stated = len(body) if length is None else length
    return HEAD.format(method=method, path=path, host=host, kind=kind, length=stated).encode() + body


def asking(name: str, operation: str, body: bytes | object) -> Hostile:
    data = body if isinstance(body, bytes) else json.dumps(body).encode()
    return Hostile(f"{operation}: {name}", lambda session: raw(f"/sessions/{session}/{operation}", data))


def deep(levels: int) -> bytes:
    return b'{"problem": ' + b'{"a": ' * levels + b"1" + b"}" * levels + b"}"


MALFORMED: dict[str, bytes] = {
    "nothing but a brace": b"{",
    "a list": b"[]",
    "a number": b"1",
    "a text": b'"plan"',
    "null": b"null",
    "no UTF-8": b'{"problem": "\xff\xfe"}',
    "twice the same key": b'{"problem": {}, "problem": {}}',
    "200 levels": deep(200),
    "100000 levels": deep(100_000),
    "100000 brackets": b"[" * 100_000,
    "a number of 5000 digits": b'{"problem": {"knots": ' + b"9" * 5000 + b"}}",
    "a key that nobody knows": b'{"pickle": "gASVAAAA"}',
    "a pickle": b"\x80\x05\x95\x0c\x00\x00\x00\x00\x00\x00\x00\x8c\x05posix.",
    "trailing words": b"{} DROP TABLE robots",
}
WRONG: tuple[Any, ...] = (
    None,
    1,
    -1,
    1e308,
    "elbow",
    [],
    [[]],
    {},
    {"a": 1},
    True,
    [None],
    ["/etc/passwd"],
)
NOT_A_NUMBER = (b"NaN", b"Infinity", b"-Infinity", b"1e999")
SCENE: dict[str, Any] = {
    "a box that is a text": {"add": {"name": "a", "shape": {"box": {"x": "wide", "y": 1, "z": 1}}}},
    "a box of a negative size": {"add": {"name": "a", "shape": {"box": {"x": -1, "y": 1, "z": 1}}}},
    "a box larger than a house": {"add": {"name": "a", "shape": {"box": {"x": 1e9, "y": 1, "z": 1}}}},
    "a mesh of a file": {"add": {"name": "a", "shape": {"mesh": {"uri": "file:///etc/passwd"}}}},
    "a mesh of a package": {"add": {"name": "a", "shape": {"mesh": {"uri": "package://a/../../etc/passwd"}}}},
    "a mesh of an address": {"add": {"name": "a", "shape": {"mesh": {"uri": "http://127.0.0.1:1/"}}}},
    "a mesh whose faces have no corners": {
        "add": {"name": "a", "shape": {"mesh": {"vertices": [], "faces": [[0, 1, 2]]}}}
    },
    "a mesh of texts": {"add": {"name": "a", "shape": {"mesh": {"vertices": "abc", "faces": "def"}}}},
    "a mesh with far too many faces": {
        "add": {"name": "a", "shape": {"mesh": {"vertices": [[0, 0, 0]], "faces": [[0, 0, 0]] * 60_000}}}
    },
    "a name that is a path": {"remove": {"name": "../../etc/passwd"}},
    "a method of Python's": {"__reduce__": {}},
    "two edits in one": {"remove": {"name": "a"}, "add": {"name": "a", "shape": {"sphere": {"radius": 1}}}},
    "an object in itself": {"move": {"name": "a", "placement": {"xyz": [0, 0, 0]}, "frame": "a"}},
    "self given": {"remove": {"self": 1, "name": "a"}},
    "self taken away": {"remove": {"self": None, "name": "a"}},
    "a frame nobody knows": {"add": {"name": "b", "shape": {"sphere": {"radius": 0.1}}, "frame": "nowhere"}},
    "a quaternion of no length": {
        "add": {"name": "c", "shape": {"sphere": {"radius": 0.1}}, "placement": {"quaternion": [0, 0, 0, 0]}}
    },
    "a joint nobody knows": {"stand": {"joint99": 0.1}},
    "too few positions": {"stand": [0.1]},
}
TRAVERSAL = (
    "/../etc/passwd", "/..%2f..%2fetc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/page.js/../../../run.py",
    "/pages/..\\..\\etc\\passwd", "/.git/config", "//etc/passwd", "/static/%00",
)  # fmt: skip


def hostile() -> Iterator[Hostile]:
    """Yield all of them."""
    for name, body in MALFORMED.items():
        yield asking(name, "plan", body)
    for value in WRONG:
        yield asking(f"a problem that is {value!r}", "plan", {"problem": value})
        yield asking(f"a goal that is {value!r}", "plan", {"problem": {"goal": value}})
    for literal in NOT_A_NUMBER:
        body = b'{"problem": {"goal": {"joint_positions": {"positions": {"joint1": %b}}}}}' % literal
        yield asking(f"a joint at {literal.decode()}", "plan", body)
        box = b'{"edits": [{"add": {"name": "n", "shape": {"sphere": {"radius": %b}}}}]}' % literal
        yield asking(f"a radius of {literal.decode()}", "edit", box)
    for name, edit in SCENE.items():
        yield asking(name, "edit", {"edits": [edit]})
    for field, value in (("knots", 10**9), ("velocity_scaling", 1e9), ("finish_by", -1), ("dwell", "long")):
        yield asking(f"{field} {value}", "plan", {"problem": {"goal": GOAL, field: value}})
    yield from of_operations()
    yield from of_clouds()
    yield from of_http()


def of_operations() -> Iterator[Hostile]:
    points: list[Any] = [{"time_from_start": float(i), "positions": [0.0, 0.0]} for i in range(25_000)]
    for name, rows in (("too many points", points), ("time runs back", points[:2][::-1])):
        trajectory = {"joint_names": ["joint1", "joint2"], "points": rows}
        yield asking(name, "check", {"problem": {"goal": GOAL}, "trajectory": trajectory})
    yield asking("positions of texts", "forward_kinematics", {"positions": ["a", "b"]})
    yield asking("a frame that is a number", "forward_kinematics", {"frames": [1]})
    yield asking("a goal without a goal", "inverse_kinematics", {"goal": {}})
    yield asking("a negative margin", "validity", {"margin": -1})
    yield asking("a negative speed", "execute", {"problem": {"goal": GOAL}, "speed": -1})
    yield asking("a motion of nobody", "motions", {"motions": [{"object": "nobody", "times": [0, 1]}]})
    yield asking("a curve that is none", "follow", {"follows_curve": {"frame": "tool", "curve": 1}})
    yield asking("an unknown operation", "exec", {"code": "import os"})
    yield asking("an operation of dunders", "__class__", {})


def clouded(name: str, data: bytes, address: str = "?radius=0.01", **more: Any) -> Hostile:
    path = "/sessions/{}/cloud" + address
    kind = more.pop("kind", "application/octet-stream")
    return Hostile(f"cloud: {name}", lambda session: raw(path.format(session), data, kind=kind, **more))


def npy(header: str, data: bytes = b"") -> bytes:
    """Return what looks like a file of numpy's, with any header."""
    words = header.encode()
    return b"\x93NUMPY\x01\x00" + len(words).to_bytes(2, "little") + words + data


def of_clouds() -> Iterator[Hostile]:
    one = bytes(12)
    rows = "{'descr': '%s', 'fortran_order': %s, 'shape': %s, }\n"
    yield clouded("half a point", bytes(10))
    yield clouded("more points than there may be", bytes(12 * 120_000))
    yield clouded("a pickle in numpy's form", npy(rows % ("|O", False, "(1, 3)"), b"\x80\x05cos\nsystem\n."))
    yield clouded("more rows than memory", npy(rows % ("<f4", False, "(10000000000, 3)"), one))
    yield clouded("a negative number of rows", npy(rows % ("<f4", False, "(-1, 3)"), one))
    yield clouded("two columns", npy(rows % ("<f4", False, "(6, 2)"), bytes(48)))
    yield clouded("columns first", npy(rows % ("<f4", True, "(1, 3)"), one))
    yield clouded("texts", npy(rows % ("<U1", False, "(1, 3)"), one))
    yield clouded("a record", npy(rows.replace("'%s'", "%s") % ([("a", "<f4")], False, "(3,)"), one))
    yield clouded("code for a header", npy("__import__('os').system('id')\n", one))
    yield clouded("a header of brackets", npy("[" * 9_000, one))
    yield clouded("a header that does not end", b"\x93NUMPY\x01\x00\xff\xff{")
    yield clouded("a format of tomorrow", b"\x93NUMPY\x09\x00\x01\x00 " + one)
    yield clouded("wider than a house", bytes(12) + b"\x00\x00\x80\x4e" * 3)
    yield clouded("JSON", b"{}", kind="application/json")
    yield clouded("a form", b"a=1", kind="application/x-www-form-urlencoded")
    for address in (
        "?radius=0", "?radius=-1", "?radius=NaN", "?radius=1e999", "?radius=wide", "?radius=%5B%5D",
        "?radius=1&radius=2", "?radius=0.1&shell=id", "?radius=0.1&name=", "?radius=0.1&name=link1",
        "?radius=0.1&stamp=late", "?cell=0", "?frame=nowhere", "?placement=%7B%22xyz%22%3A1%7D",
        "?points=%5B%5D", "?positions=%5B1%5D", "?radius=0.1&timeout=-1",
    ):  # fmt: skip
        yield clouded(f"at {address}", one, address)


def of_http() -> Iterator[Hostile]:
    for path in TRAVERSAL:
        yield Hostile(f"GET {path}", lambda _, path=path: raw(path, b"", method="GET"))
    plan = "/sessions/{}/plan"
    yield Hostile("too large", lambda s: raw(plan.format(s), b" " * HUGE), cut=True)
    yield Hostile("said to be too large", lambda s: raw(plan.format(s), b"", length=10**12))
    yield Hostile(
        "a length that is none", lambda s: raw(plan.format(s), b"{}").replace(b": 2", b": two"), cut=True
    )
    yield Hostile("a negative length", lambda s: raw(plan.format(s), b"{}", length=-1), cut=True)
    yield Hostile("a form", lambda s: raw(plan.format(s), b"a=1", kind="application/x-www-form-urlencoded"))
    yield Hostile("plain text", lambda s: raw(plan.format(s), b"{}", kind="text/plain"))
    yield Hostile("another name of the server", lambda s: raw(plan.format(s), b"{}", host="evil.example"))
    yield Hostile("a session of nobody", lambda _: raw(plan.format("0" * 22), b"{}"))
    yield Hostile("a session that is a path", lambda _: raw(plan.format("..%2f.."), b"{}"))
    yield Hostile("a session of nonsense", lambda _: raw("/sessions", b'{"robot": ["panda"]}'))
    yield Hostile("a robot that is a file", lambda _: raw("/sessions", b'{"robot": "/etc/passwd"}'))
    yield Hostile("no HTTP at all", lambda _: b"\x00\x01\x02 hello\r\n\r\n", cut=True)
    yield Hostile("a head of 100 kB", lambda s: raw(plan.format(s), b"{}", host="a" * 100_000), cut=True)
    yield Hostile("a timeout of words", lambda s: raw(plan.format(s) + "?timeout=long", b"{}"))
    yield Hostile("a timeout of nothing", lambda s: raw(plan.format(s) + "?timeout=0", b"{}"))
    yield Hostile("a method nobody knows", lambda s: raw(plan.format(s), b"{}", method="BREW"))
    yield Hostile(
        "another site",
        lambda s: raw(plan.format(s), b"{}").replace(b"Host", b"Origin: http://evil\r\nHost", 1),
    )
    yield Hostile("a body that does not come", lambda s: raw(plan.format(s), b'{"pro', length=100), cut=True)
    yield Hostile(
        "a head that does not end", lambda _: b"POST /sessions HTTP/1.1\r\nHost: localhost\r\n", cut=True
    )
    yield Hostile("nothing", lambda _: b"", cut=True)
