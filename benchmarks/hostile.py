"""Hostile requests to `trajopt serve` while its workers are killed: how they end, and if an edit is lost.

python -m benchmarks.hostile [--requests 12500] [--kills 84] [--seed 0] [--page FILE]

Four of five requests are those of `tests/server/hostile.py`, most of them changed at random: flipped bits,
parts cut, doubled or inserted, noise. The others are honest: plans, and edits that each add a box. Workers
are killed by SIGKILL at random moments, and in the end the server itself. An edit is lost if it was
acknowledged and its box is missing. A fault is no answer in 90 s, or a status of 500 and above other than of
a request whose worker was killed.
"""

import argparse
import asyncio
import json
import os
import random
import signal
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, cast
from urllib.parse import urlsplit

from benchmarks.page import table, write_section
from benchmarks.server import Server
from tests.server.hostile import hostile, raw
from trajopt.server.limits import Why

CONNECTIONS, PATIENCE = 12, 90.0
CHANGED = 0.8
"""Share of the hostile requests that are changed at random."""
PROBLEM = {"group": "panda_arm", "goal": {"joint_positions": {"positions": {"panda_joint1": 0.3}}}}
PARTS = (b"null", b"[" * 50, b"1e999", b"\\ud800", b"NaN", b"\xff", b'"a":', b"{}", b"9" * 400, b"\0")
NO_ANSWER, CLOSED = -1, 0
Words = dict[str, Any]


@dataclass
class Load:
    """The requests so far.

    Attributes:
        hostile: How many hostile requests ended with which status and kind of refusal.
        honest: How many honest requests ended with which status.
        faults: Hostile requests that are faults of the server, by name.
        acknowledged: Boxes of edits that were acknowledged.
        unsure: Boxes of edits that were not.
        killed: Workers that were killed.
        memory: Memory of all processes on the way [MB].
    """

    hostile: Counter[str] = field(default_factory=Counter[str])
    honest: Counter[str] = field(default_factory=Counter[str])
    faults: list[str] = field(default_factory=list[str])
    acknowledged: set[str] = field(default_factory=set[str])
    unsure: set[str] = field(default_factory=set[str])
    killed: int = 0
    memory: list[float] = field(default_factory=list[float])


async def answer(server: Server, data: bytes) -> tuple[int, bytes]:
    """Send bytes; return the status and the body of the answer, or `NO_ANSWER` or `CLOSED`."""
    where = urlsplit(server.url)
    reader, writer = await asyncio.open_connection(where.hostname, where.port)
    try:
        with suppress(OSError):  # the server may refuse before it has read everything
            writer.write(data)
            await writer.drain()
        return await asyncio.wait_for(_read(reader), PATIENCE)
    except TimeoutError:
        return NO_ANSWER, b""
    except (asyncio.IncompleteReadError, OSError):
        return CLOSED, b""
    finally:
        writer.close()


async def _read(reader: asyncio.StreamReader) -> tuple[int, bytes]:
    head = (await reader.readuntil(b"\r\n\r\n")).lower()
    length = head.partition(b"content-length:")[2].split(b"\r\n")[0]
    return int(head.split()[1]), await reader.readexactly(int(length or b"0"))


async def asked(server: Server, path: str, words: Words | None, *, method: str = "POST") -> tuple[int, Words]:
    """Send an honest request; return the status and the answer."""
    body = b"" if words is None else json.dumps(words).encode()
    status, content = await answer(server, raw(path, body, method=method))
    return status, json.loads(content) if content.startswith(b"{") else {}


def changed(data: bytes, rng: random.Random) -> bytes:
    """Return a request with its body, or in one of seven cases its head, changed at random."""
    head, _, body = data.partition(b"\r\n\r\n")
    case = rng.randrange(len(CHANGES) + 1)
    if case == len(CHANGES):
        spoilt = bytearray(head)
        for _ in range(min(4, len(head))):
            spoilt[rng.randrange(len(spoilt))] = rng.choice(b"\r\n :\0/abc%?\xff")
        return bytes(spoilt) + b"\r\n\r\n" + body
    content = CHANGES[case](bytearray(body or b"{}"), rng)
    lines = [line for line in head.split(b"\r\n") if not line.lower().startswith(b"content-length")]
    return b"\r\n".join([*lines, b"Content-Length: %d" % len(content), b"", bytes(content)])


def _flipped(body: bytearray, rng: random.Random) -> bytes:
    for _ in range(rng.randint(1, 8)):
        body[rng.randrange(len(body))] ^= 1 << rng.randrange(8)
    return bytes(body)


def _between(body: bytearray, rng: random.Random) -> tuple[int, int]:
    one, other = rng.randrange(len(body) + 1), rng.randrange(len(body) + 1)
    return min(one, other), max(one, other)


def _cut(body: bytearray, rng: random.Random) -> bytes:
    return bytes(body[: rng.randrange(len(body) + 1)])


def _without_a_part(body: bytearray, rng: random.Random) -> bytes:
    first, last = _between(body, rng)
    return bytes(body[:first] + body[last:])


def _with_a_part_twice(body: bytearray, rng: random.Random) -> bytes:
    first, last = _between(body, rng)
    return bytes(body[:last] + body[first:])


def _with_a_part_more(body: bytearray, rng: random.Random) -> bytes:
    place = rng.randrange(len(body) + 1)
    return bytes(body[:place]) + rng.choice(PARTS) + bytes(body[place:])


def _noise(_: bytearray, rng: random.Random) -> bytes:
    return rng.randbytes(rng.randrange(300))


CHANGES: Sequence[Callable[[bytearray, random.Random], bytes]] = (
    _flipped, _cut, _without_a_part, _with_a_part_twice, _with_a_part_more, _noise,
)  # fmt: skip


async def edit(server: Server, session: str, name: str, load: Load) -> None:
    """Add a box to a session."""
    shape = {"box": {"x": 0.01, "y": 0.01, "z": 0.01}}
    box = {"name": name, "shape": shape, "placement": {"xyz": [3.0, 3.0, 3.0]}}
    status, _ = await asked(server, f"/sessions/{session}/edit", {"edits": [{"add": box}]})
    load.honest[f"edits {status}"] += 1
    (load.acknowledged if status == 200 else load.unsure).add(name)


async def attack(server: Server, session: str, rng: random.Random, load: Load) -> None:
    """Send a hostile request to a session."""
    request = rng.choice(ATTACKS)
    data = request.make(session)
    status, body = await answer(server, changed(data, rng) if rng.random() < CHANGED else data)
    kind = ""
    with suppress(ValueError, TypeError, KeyError):
        kind = cast(str, json.loads(body)["error"]["kind"])
    load.hostile["closed without an answer" if status == CLOSED else f"{status} {kind}".strip()] += 1
    if status == NO_ANSWER or (status >= 500 and kind != Why.WORKER_LOST.value):
        load.faults.append(f"{request.name}: {status} {kind}")


ATTACKS = tuple(hostile())


async def campaign(server: Server, requests: int, kills: int, seed: int, load: Load) -> str:
    """Send all requests; return the session of the edits."""
    victim, edited = [(await asked(server, "/sessions", {}))[1]["session"] for _ in range(2)]
    numbers = iter(range(requests))
    deaths = set(random.Random(seed).sample(range(requests), kills))

    async def client(rng: random.Random) -> None:
        for number in numbers:
            if number in deaths:
                with suppress(ProcessLookupError):
                    os.kill(rng.choice(server.pids[1:]), signal.SIGKILL)
                    load.killed += 1
            if number % 10 == 0:
                await edit(server, edited, f"box {number}", load)
            elif number % 10 == 5:
                status, _ = await asked(server, f"/sessions/{edited}/plan", {"problem": PROBLEM})
                load.honest[f"plans {status}"] += 1
            else:
                await attack(server, victim, rng, load)
            if number % max(requests // 50, 1) == 0:
                load.memory.append(server.memory)

    await asyncio.gather(*(client(random.Random(f"{seed} {number}")) for number in range(CONNECTIONS)))
    return edited


async def boxes(server: Server, session: str) -> set[str]:
    """Return the boxes that are in a session."""
    status, content = await asked(server, f"/sessions/{session}", None, method="GET")
    return set(content["objects"]) if status == 200 else set()


def main(words: Sequence[str] | None = None) -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--requests", type=int, default=12_500)
    parser.add_argument("--kills", type=int, default=84)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--page", type=Path)
    given = parser.parse_args(words)
    load = Load()
    with TemporaryDirectory() as folder:
        kept = ("--warehouse", f"{folder}/sessions")
        server = Server.started(*kept)
        try:
            session = asyncio.run(campaign(server, given.requests, given.kills, given.seed, load))
            before = asyncio.run(boxes(server, session))
        finally:
            server.process.kill()
            server.process.wait()
        again = Server.started(*kept)
        try:
            after = asyncio.run(boxes(again, session))
        finally:
            again.process.send_signal(signal.SIGTERM)
            again.process.wait(30.0)
    text = page(load, before, after)
    print(text)
    if given.page is not None:
        write_section(given.page, "hostile", text)


def page(load: Load, before: set[str], after: set[str]) -> str:
    """Return the section of the page."""
    tenth = max(len(load.memory) // 10, 1)
    first, last = (sum(part) / len(part) for part in (load.memory[:tenth], load.memory[-tenth:]))
    rows = [
        ("hostile requests", str(load.hostile.total())),
        ("of these ended with", _listed(load.hostile)),
        ("faults of the server", f"{len(load.faults)} {'; '.join(load.faults[:5])}".strip()),
        ("honest requests", _listed(load.honest)),
        ("workers killed", str(load.killed)),
        ("edits that were acknowledged", str(len(load.acknowledged))),
        ("of these lost", str(len(load.acknowledged - before))),
        ("of these lost after the server itself was killed", str(len(load.acknowledged - after))),
        ("boxes that no edit asked for", str(len((before | after) - load.acknowledged - load.unsure))),
        ("memory, first and last tenth", f"{first:.0f} and {last:.0f} MB"),
    ]
    return table(["", ""], [list(row) for row in rows])


def _listed(ended: Counter[str]) -> str:
    return ", ".join(f"{count} x {how}" for how, count in ended.most_common())


if __name__ == "__main__":
    main()
