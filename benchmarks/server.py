"""The server under load: many requests on many connections, compared with the bare `plan()`.

python -m benchmarks.server [--requests 10000] [--connections 50] [--kill 1000] [--page FILE]

A Panda plans in the scenes of seven installed problems, one session each, from starts near theirs to the
configurations that their plans end in. The server is `trajopt serve` in processes of its own on this machine:
two plan, and fewer requests may wait than there are connections, so that some are told to come again. CPU is
that of all its processes together, as the system counts it; that of the bare `plan()` is measured in this
process before and after, of the same problems. Then, among other requests, a process that plans is killed.
"""

import argparse
import asyncio
import os
import re
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import httpx
import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from trajopt.robot.configuration import initial_positions
from trajopt.server import SessionState, Watch
from trajopt.server.client import AsyncClient, AsyncSession, ServerError
from trajopt.server.limits import memory_used
from trajopt.server.operations import OPERATIONS
from trajopt.server.operations.scenes import edited
from trajopt.values.documents.document import Node

KINDS = ("bar", "between_plates", "cage", "narrow_mouth", "past_pillar", "turn_over", "under_table")
VARIANTS = 5
WORKERS, WAITING = 2, 16
TICK = os.sysconf("SC_CLK_TCK")
Words = dict[str, Any]


@dataclass
class Load:
    """What came of the requests.

    Attributes:
        ended: How many ended how.
        seconds: How long each took, waiting and coming again included [s].
    """

    ended: Counter[str] = field(default_factory=Counter[str])
    seconds: list[float] = field(default_factory=list[float])


@dataclass(frozen=True)
class Scene:
    """A scene, and problems in it.

    Attributes:
        edits: The scene in words.
        problems: The problems.
        words: The same in words.
    """

    edits: list[Words]
    problems: list[to.Problem]
    words: list[Words]


def scene_of(name: str, rng: np.random.Generator) -> Scene:
    """Return the scene of an installed problem, and problems in it that go between configurations."""
    problem = to.named_problem(name)
    panda = problem.scene.robot
    state = SessionState("panda", problem.scene, problem.start_positions)
    described = cast(Words, OPERATIONS["read"].run(state, Node({}, "read"), Watch(60.0)).document)
    edits: list[Words] = []
    for key, item in described["objects"].items():
        parts = [[each["shape"], each["placement"]] for each in item["parts"]]
        edits.append({"add": {"name": key, "shape": parts, "placement": item["placement"]}})
    empty = SessionState("panda", to.Scene(panda), initial_positions(panda))
    scene = edited(empty, Node(edits, "edits")).scene
    reached = to.plan(problem).require().trajectory.positions[-1].tolist()
    joints = problem.reduced.joint_names
    goal = dict(zip(joints, reached, strict=True))
    found = Scene(edits, [], [])
    begin = problem.start_positions[panda.index(joints)]
    for _ in range(VARIANTS):
        varied = begin + rng.uniform(-0.05, 0.05, len(begin))
        start = dict(zip(joints, varied.tolist(), strict=True))
        same = to.Problem(scene=scene, group=problem.group, start=start, goal=to.joint_positions(goal))
        to.plan(same).require()
        found.problems.append(same)
        reach = {"joint_positions": {"positions": goal}}
        found.words.append({"group": problem.group, "start": start, "goal": reach})
    return found


def bare(problems: Sequence[to.Problem], times: int) -> float:
    """Return the CPU time of a bare plan, the mean over problems [s]."""
    begin = time.process_time()
    for _ in range(times):
        for problem in problems:
            to.plan(problem)
    return (time.process_time() - begin) / (times * len(problems))


@dataclass
class Server:
    """The server's processes."""

    process: subprocess.Popen[str]
    url: str

    @staticmethod
    def started(*options: str) -> "Server":
        """Start a server of a Panda, with further options of `trajopt serve`."""
        command = [sys.executable, "-m", "trajopt", "serve", "--robot", "panda", "--port", "0"]
        command += ["--workers", str(WORKERS), "--waiting", str(WAITING), *options]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        assert process.stdout is not None
        return Server(process, process.stdout.readline().split()[-1])

    @property
    def pids(self) -> list[int]:
        """Its processes, itself first."""
        listed = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text()
        return [self.process.pid, *map(int, listed.split())]

    @property
    def cpu(self) -> float:
        """CPU time of all its processes that are there [s]."""
        used = 0
        for pid in self.pids:
            fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
            used += int(fields[11]) + int(fields[12])
        return used / TICK

    @property
    def memory(self) -> float:
        """Memory of all its processes [MB]."""
        return sum(memory_used(pid) for pid in self.pids) / 2**20

    def count(self, outcome: str) -> int:
        """How many plans ended so, by its own numbers."""
        numbers = httpx.get(f"{self.url}/metrics").text
        line = rf'trajopt_requests_total\{{operation="plan",outcome="{outcome}"\}} (\S+)'
        found = re.search(line, numbers)
        return int(float(found[1])) if found else 0

    def planner(self) -> int:
        """One of the processes that plan: of the workers the one with the most CPU time."""
        return max(self.pids[1:], key=lambda pid: int(Path(f"/proc/{pid}/stat").read_text().split()[13]))


async def load(
    server: Server, scenes: Sequence[Scene], requests: int, connections: int, *, kill: bool = False
) -> tuple[Load, list[float]]:
    """Send requests from many connections; return their outcomes, and the memory over time [MB]."""
    seen, memory, left = Load(), list[float](), iter(range(requests))

    async def one(session: AsyncSession, scene: Scene) -> None:
        for number in left:
            begin = time.monotonic()
            try:
                answer = await session.plan(scene.words[number % VARIANTS])
                seen.ended["verified" if answer["verified"] else answer["status"]] += 1
            except ServerError as error:
                seen.ended[error.kind] += 1
            seen.seconds.append(time.monotonic() - begin)
            if number % max(requests // 50, 1) == 0:
                memory.append(server.memory)
            if kill and number == requests // 2:
                os.kill(server.planner(), signal.SIGKILL)

    async with AsyncClient(server.url, connections=connections, patience=600.0, timeout=600.0) as client:
        sessions = [await client.session("panda") for _ in scenes]
        await asyncio.gather(*(each.edit(scene.edits) for each, scene in zip(sessions, scenes, strict=True)))
        pairs = list(zip(sessions, scenes, strict=True))
        await asyncio.gather(*(one(*pairs[i % len(pairs)]) for i in range(connections)))
        await asyncio.gather(*(each.close() for each in sessions))
    return seen, memory


def main(words: Sequence[str] | None = None) -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--requests", type=int, default=10_000)
    parser.add_argument("--connections", type=int, default=50)
    parser.add_argument("--kill", type=int, default=1000, help="requests among which a process is killed")
    parser.add_argument("--page", type=Path)
    given = parser.parse_args(words)
    rng = np.random.default_rng(1)
    scenes = [scene_of(f"{kind}_panda", rng) for kind in KINDS]
    problems = [problem for scene in scenes for problem in scene.problems]
    before = bare(problems, 5)
    server = Server.started()
    try:
        asyncio.run(load(server, scenes, 2 * len(problems), given.connections))  # caches are filled
        full, cpu, begin = server.count("full"), server.cpu, time.monotonic()
        seen, memory = asyncio.run(load(server, scenes, given.requests, given.connections))
        took, cpu, full = time.monotonic() - begin, server.cpu - cpu, server.count("full") - full
        killed, _ = asyncio.run(load(server, scenes, given.kill, given.connections, kill=True))
    finally:
        server.process.send_signal(signal.SIGTERM)
        server.process.wait(30.0)
    alone = (before + bare(problems, 5)) / 2.0
    text = page(given, seen, memory, took, cpu / given.requests, alone, full, killed)
    print(text)
    if given.page is not None:
        write_section(given.page, "server", text)


def page(
    given: argparse.Namespace,
    seen: Load,
    memory: Sequence[float],
    took: float,
    cpu: float,
    alone: float,
    full: int,
    killed: Load,
) -> str:
    """Return the section of the page."""
    tenth, latency = max(len(memory) // 10, 1), np.percentile(seen.seconds, (50, 99)).tolist()
    rows = [
        ("requests, connections", f"{given.requests}, {given.connections}"),
        ("ended", said(seen.ended)),
        ("rejected with 429", str(full)),
        ("CPU of all the server's processes for each", f"{1e3 * cpu:.1f} ms"),
        ("CPU of the bare `plan()`", f"{1e3 * alone:.1f} ms"),
        ("ratio", f"{cpu / alone:.2f}"),
        ("latency, median and 99 %", " and ".join(f"{each:.2f} s" for each in latency)),
        ("requests a second", f"{given.requests / took:.1f}"),
        (
            "memory, first and last tenth",
            f"{np.mean(memory[:tenth]):.0f} and {np.mean(memory[-tenth:]):.0f} MB",
        ),
        (f"a process killed among {given.kill} requests", said(killed.ended)),
    ]
    return table(["", ""], [list(row) for row in rows])


def said(ended: Counter[str]) -> str:
    return ", ".join(f"{count} {how}" for how, count in ended.most_common())


if __name__ == "__main__":
    main()
