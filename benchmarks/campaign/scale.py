"""Campaigns in sequence, each ten times as large: time for planning, overhead and memory.

python -m benchmarks.campaign.scale [--counts 1000,10000] [--robot planar2|panda] [--engines local,ray]

Of every run, from the campaign's first line on disk to its last row: the process time of planning, of all
else that runs for it (the driver, the workers' start, reading and sending, the engine's own processes), and
how long the cores had nothing to do and the workers waited. What of the cores is left goes to other work of
the machine, so that

    reached = planning / (planning + all else + lost)

is the share of (cores x single-core rate) that the campaign had of what the machine left to it: rows by
process time of planning is the rate of one core in the same run, and the sum below the line is what the cores
gave, on a machine of one's own cores x wall-clock time. Lost is the larger of what cores had nothing to do
and what workers waited: the first is small where other work fills the cores, the second then too large. The
start, until the first rows are on disk, costs the same for ten problems and for a million: it is told apart.
"""

import argparse
import compileall
import json
import os
import shutil
import time
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path

import trajopt as to
from benchmarks.campaign.cluster import Cluster, cluster, cpu_seconds, memory, workers
from trajopt.lab.campaign import Campaign, Local, Progress, Ray, random_motions, run_campaign

WORKERS = 2
CORES = os.cpu_count() or 1
SAMPLES = 5.0
"""Processes are looked at so often [s]."""


@dataclass(frozen=True)
class Measured:
    """One run.

    Attributes:
        engine: What planned.
        robot: Whose motions.
        rows: Rows.
        verified: Of these, with a verified motion.
        seconds: Wall-clock time [s].
        planning: Process time of planning [s].
        others: Process time of all else that runs for it [s].
        start: Of it, what came before the first rows were on disk [s].
        idle: Time that cores had nothing to do, summed over them [s].
        elsewhere: Process time of what else ran on the machine [s].
        waited: Wall-clock time that workers waited for work after their first problem [s].
        megabytes: Memory of the driver, and of the largest worker, at a tenth, at half and at the end [MB].
        shards: Files of results.
        bytes: Their size.
    """

    engine: str
    robot: str
    rows: int
    verified: int
    seconds: float
    planning: float
    others: float
    start: float
    idle: float
    elsewhere: float
    waited: float
    megabytes: list[tuple[float, float]]
    shards: int
    bytes: int


class Watch:
    """Looks at the processes of a run while it runs."""

    def __init__(self, nodes: Cluster | None) -> None:
        self._cluster, self._next = nodes, 0.0
        self._before, self._begun, self._rested = self._used(), time.monotonic(), rested()
        self._seen: dict[int, float] = {}
        self.seconds = self.idle = self.start = 0.0
        self.last: Progress | None = None
        self.megabytes: list[tuple[float, float]] = []

    def __call__(self, state: Progress) -> None:
        """Record the CPU time used by processes."""
        self.last = state
        if state.planned and not self.start:
            self._seen |= self._used()
            self.start = self.used - state.busy
        due = (0.1, 0.5, 0.999)[len(self.megabytes)] if len(self.megabytes) < 3 else 2.0
        if state.done >= due * state.total:
            largest = max(map(memory, workers(self._engine())), default=0.0)
            self.megabytes.append((memory(os.getpid()), largest))
        elif time.monotonic() < self._next and state.done < state.total:
            return
        self._next = time.monotonic() + SAMPLES
        self._seen |= self._used()
        self.seconds, self.idle = time.monotonic() - self._begun, rested() - self._rested

    @property
    def used(self) -> float:
        """Process time of the driver, the workers and the engine, to when they were last looked at [s]."""
        return sum(each - self._before.get(pid, 0.0) for pid, each in self._seen.items())

    def _used(self) -> dict[int, float]:
        engine = self._engine()
        found = {pid: cpu_seconds(pid) for pid in {*workers(engine), *engine}}
        return {**found, os.getpid(): time.process_time()}

    def _engine(self) -> set[int]:
        return {os.getpid()} if self._cluster is None else {os.getpid(), *self._cluster.mine()}


def rested() -> float:
    """Return how long the machine's cores have had nothing to do, summed over them [s]."""
    idle, waiting = Path("/proc/stat").read_text().split()[4:6]
    return (int(idle) + int(waiting)) / os.sysconf("SC_CLK_TCK")


def motions(robot: str, count: int) -> Campaign:
    """Return random motions of two joints next to a ball, or of a Panda's arm above a table."""
    scene = to.Scene(to.load(robot))
    if robot == "panda":
        scene = scene.add("table", to.Box(1.0, 1.0, 0.1), to.placement((0.5, 0.0, -0.06)))
    else:
        scene = scene.add("ball", to.Sphere(0.1), to.placement((0.65, 0.65, 0.1)))
    group = "panda_arm" if robot == "panda" else ""
    return Campaign(f"{count} random motions", [random_motions(scene, count, group=group)])


def measured(count: int, robot: str, name: str, nodes: Cluster | None, out: Path) -> Measured:
    """Run a campaign of random motions."""
    campaign = motions(robot, count)
    engine = Local(WORKERS) if nodes is None else Ray(nodes.address)
    shutil.rmtree(out, ignore_errors=True)
    watch = Watch(nodes)
    folder = run_campaign(campaign, out, engine, progress=watch)
    assert watch.last is not None
    last, shards = watch.last, folder.shards
    assert len(folder.done()) == count == last.done
    return Measured(
        engine=name,
        robot=robot,
        rows=count,
        verified=last.verified,
        seconds=watch.seconds,
        planning=last.busy,
        others=watch.used - last.busy,
        start=watch.start,
        idle=watch.idle,
        elsewhere=CORES * watch.seconds - watch.used - watch.idle,
        waited=last.waited,
        megabytes=watch.megabytes,
        shards=len(shards),
        bytes=sum(shard.stat().st_size for shard in shards),
    )


def main() -> None:
    """Run the requested campaign, and append its figures to a file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--counts", default="1000,10000")
    parser.add_argument("--robot", choices=("planar2", "panda"), default="planar2")
    parser.add_argument("--engines", default="local,ray")
    parser.add_argument("--out", type=Path, default=Path("out/campaign"))
    parser.add_argument("--results", type=Path, default=Path("benchmarks/results/campaign_scale.jsonl"))
    given = parser.parse_args()
    compileall.compile_dir(str(Path(to.__file__).parent), quiet=1)  # as pip does when it installs
    for engine in given.engines.split(","):
        with ExitStack() as stack:
            nodes = stack.enter_context(cluster(given.out / "ray", WORKERS)) if engine == "ray" else None
            for count in map(int, given.counts.split(",")):
                found = measured(
                    count, given.robot, engine, nodes, given.out / f"{engine}_{given.robot}_{count}"
                )
                print(found, flush=True)
                given.results.parent.mkdir(parents=True, exist_ok=True)
                with given.results.open("a") as file:
                    file.write(json.dumps(asdict(found)) + "\n")


if __name__ == "__main__":
    main()
