"""One campaign after the other, each ten times as large: what is planning, what is not, and the memory.

python -m benchmarks.campaign.scale [--counts 1000,10000] [--engines local,ray] [--results FILE]

Of every run: its rows in a second, the process time of planning, of all else that runs for it (the driver,
the workers' reading and sending, the engine's own processes), and how long workers waited for work. On a
machine that does other work as well wall-clock time says little: so beside it stands the share of planning in
all that the run took from the cores or left unused, which on a machine of one's own is the same.
"""

import argparse
import json
import os
import shutil
import time
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path

import trajopt as to
from benchmarks.campaign.cluster import Cluster, cluster, cpu_seconds, memory, workers
from trajopt.campaign import Campaign, Local, Progress, Ray, random_motions, run_campaign

WORKERS = 2
SAMPLES = 1.0
"""Processes are looked at so often [s]."""


@dataclass(frozen=True)
class Measured:
    """One run.

    Attributes:
        engine: What planned.
        rows: Rows.
        verified: Of these, with a verified motion.
        seconds: Wall-clock time [s].
        planning: Process time of planning [s].
        others: Process time of all else [s].
        waited: Wall-clock time that workers waited for work [s].
        megabytes: Memory of the driver, and of the largest worker, at a tenth, at half and at the end [MB].
        shards: Files of results.
        bytes: Their size.
        load: Processes that wanted the cores, the mean of the last minute at the end.
    """

    engine: str
    rows: int
    verified: int
    seconds: float
    planning: float
    others: float
    waited: float
    megabytes: list[tuple[float, float]]
    shards: int
    bytes: int
    load: float


class Watch:
    """Looks at the processes of a run while it runs."""

    def __init__(self, nodes: Cluster | None) -> None:
        self._cluster, self._next = nodes, 0.0
        self._before = self._used()
        self._seen: dict[int, float] = {}
        self.last: Progress | None = None
        self.megabytes: list[tuple[float, float]] = []

    def __call__(self, state: Progress) -> None:
        """Note what processes have used so far."""
        self.last = state
        due = (0.1, 0.5, 0.999)[len(self.megabytes)] if len(self.megabytes) < 3 else 2.0
        if state.done >= due * state.total:
            largest = max(map(memory, workers(self._engine())), default=0.0)
            self.megabytes.append((memory(os.getpid()), largest))
        elif time.monotonic() < self._next:
            return
        self._next = time.monotonic() + SAMPLES
        self._seen |= self._used()

    @property
    def used(self) -> float:
        """Process time of the driver, the workers and the engine since the beginning [s]."""
        now = {**self._seen, os.getpid(): time.process_time()}
        return sum(each - self._before.get(pid, 0.0) for pid, each in now.items())

    def _used(self) -> dict[int, float]:
        engine = self._engine()
        found = {pid: cpu_seconds(pid) for pid in {*workers(engine), *engine}}
        return {**found, os.getpid(): time.process_time()}

    def _engine(self) -> set[int]:
        return {os.getpid()} if self._cluster is None else {os.getpid(), *self._cluster.mine()}


def measured(count: int, name: str, nodes: Cluster | None, out: Path) -> Measured:
    """Run a campaign of random motions of two joints beside a ball, which take a few milliseconds each."""
    scene = to.Scene(to.load("planar2")).add("ball", to.Sphere(0.1), to.placement((0.65, 0.65, 0.1)))
    campaign = Campaign(f"{count} random motions", [random_motions(scene, count)])
    engine = Local(WORKERS) if nodes is None else Ray(nodes.address)
    shutil.rmtree(out, ignore_errors=True)
    watch = Watch(nodes)
    folder = run_campaign(campaign, out, engine, progress=watch)
    assert watch.last is not None
    last, shards = watch.last, folder.shards
    assert len(folder.done()) == count == last.done
    return Measured(
        engine=name,
        rows=count,
        verified=last.verified,
        seconds=last.seconds,
        planning=last.busy,
        others=watch.used - last.busy,
        waited=last.waited,
        megabytes=watch.megabytes,
        shards=len(shards),
        bytes=sum(shard.stat().st_size for shard in shards),
        load=os.getloadavg()[0],
    )


def main() -> None:
    """Run what is asked, and add the figures to a file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--counts", default="1000,10000")
    parser.add_argument("--engines", default="local,ray")
    parser.add_argument("--out", type=Path, default=Path("out/campaign"))
    parser.add_argument("--results", type=Path, default=Path("benchmarks/results/campaign_scale.jsonl"))
    given = parser.parse_args()
    for engine in given.engines.split(","):
        with ExitStack() as stack:
            nodes = stack.enter_context(cluster(given.out / "ray", WORKERS)) if engine == "ray" else None
            for count in map(int, given.counts.split(",")):
                found = measured(count, engine, nodes, given.out / f"{engine}_{count}")
                print(found, flush=True)
                given.results.parent.mkdir(parents=True, exist_ok=True)
                with given.results.open("a") as file:
                    file.write(json.dumps(asdict(found)) + "\n")


if __name__ == "__main__":
    main()
