"""Faults during a campaign, on one machine and on a Ray cluster with a head and two nodes.

python -m benchmarks.campaign.faults [--count 600] [--results FILE]

Each fault comes when a third of the rows are there. Then the campaign is resumed where it ended, and its rows
are compared with those of an undisturbed campaign of this machine: as many as problems, each id once, and the
same to the last digit but for times.
"""

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeAlias

import trajopt as to
from benchmarks.campaign.cluster import Cluster, cluster, parent, processes, workers
from trajopt.lab.campaign import (
    Campaign,
    CampaignFolder,
    Local,
    Progress,
    Ray,
    random_motions,
    resume_campaign,
)
from trajopt.lab.campaign.columns import TIMES
from trajopt.lab.campaign.engine import Engine
from trajopt.values.errors import CampaignError

WORKERS = 2
COMES, STAYS = 8, 2.0
"""Number of times that a node comes and goes while rows are missing, and how long it stays [s]."""
ROOM = "1500k"
"""Of the small disk: a third of the rows fit."""


FULL = "disk full"
Fault: TypeAlias = Callable[["subprocess.Popen[bytes]", Cluster | None], None]
"""What is done to a campaign: to the process that runs it, or to a cluster."""


@dataclass(frozen=True)
class Outcome:
    """What became of a campaign that was disturbed.

    Attributes:
        engine: What planned.
        fault: What was done to it.
        before: Rows when the fault came.
        after: Rows when the campaign ended, before it was resumed.
        rows: Rows at the end.
        unique: Of these, different ids.
        same: Whether they are those of the undisturbed campaign to the last digit, but for times.
        verified: Rows with a verified motion.
    """

    engine: str
    fault: str
    before: int
    after: int
    rows: int
    unique: int
    same: bool
    verified: int


def campaign(count: int) -> Campaign:
    """Return random motions of two joints next to a ball."""
    scene = to.Scene(to.load("planar2")).add("ball", to.Sphere(0.1), to.placement((0.65, 0.65, 0.1)))
    return Campaign("random motions", [random_motions(scene, count)])


def main() -> None:
    """Disturb campaigns in all ways, and write their outcomes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--count", type=int, default=600)
    parser.add_argument("--out", type=Path, default=Path("out/faults"))
    parser.add_argument("--engines", default="local,ray")
    parser.add_argument("--faults", default="", help="only those whose name has this in it")
    parser.add_argument("--results", type=Path, default=Path("benchmarks/results/campaign_faults.json"))
    parser.add_argument("--drive", nargs=2, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.drive:
        resume_campaign(given.drive[0], engine_of(given.drive[1]))
        return
    shutil.rmtree(given.out, ignore_errors=True)
    undisturbed = resume_campaign(begun(given.count, given.out / "undisturbed").path, Local(WORKERS))
    expected, found = rows_of(undisturbed), list[Outcome]()
    if "local" in given.engines:
        for name, fault in chosen(LOCAL_FAULTS, given.faults):
            found.append(disturbed(given, "local", "", name, fault, expected))
        if given.faults in FULL:
            found.append(with_full_disk(given, "local", Local(WORKERS), expected))
    if "ray" in given.engines:
        for name, fault in chosen(RAY_FAULTS, given.faults):
            with cluster(given.out / "ray", WORKERS) as nodes:
                found.append(disturbed(given, "ray", nodes.address, name, fault, expected, nodes))
        if given.faults in FULL:
            with cluster(given.out / "ray", WORKERS) as nodes:
                found.append(with_full_disk(given, "ray", Ray(nodes.address), expected))
    kept: list[dict[str, Any]] = json.loads(given.results.read_text()) if given.results.exists() else []
    before = [Outcome(**each) for each in kept]
    all_of_them = {(each.engine, each.fault): each for each in (*before, *found)}
    given.results.write_text(json.dumps([asdict(each) for each in all_of_them.values()], indent=1) + "\n")


def chosen(faults: Mapping[str, Fault], part: str) -> list[tuple[str, Fault]]:
    """Return the faults whose names have something in them."""
    return [(name, fault) for name, fault in faults.items() if part in name]


def disturbed(
    given: argparse.Namespace,
    engine: str,
    address: str,
    name: str,
    fault: Fault,
    expected: Mapping[str, Any],
    nodes: Cluster | None = None,
) -> Outcome:
    """Run a campaign in a process of its own, disturb it, and resume it if that ended it."""
    folder = begun(given.count, given.out / f"{engine}_{name}".replace(" ", "_"))
    command = [sys.executable, "-m", "benchmarks.campaign.faults", "--drive", str(folder.path), address]
    process = subprocess.Popen(command, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})
    while len(folder.done()) < given.count // 3:
        assert process.poll() is None, "the driver ended by itself"
        time.sleep(0.2)
    before = len(folder.done())
    fault(process, nodes)
    process.wait()
    after = len(folder.done())
    if after < given.count:
        resume_campaign(folder.path, engine_of(address))
    return outcome(engine, name, folder, before, after, expected)


def with_full_disk(
    given: argparse.Namespace, name: str, engine: Engine, expected: Mapping[str, Any]
) -> Outcome:
    """Run a campaign whose results lie on a small disk, and resume it with the same files on a large one."""
    folder = begun(given.count, given.out / f"{name}_disk_full")
    results = folder.path / "results"
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={ROOM}", "tmpfs", str(results)], check=True)
    try:
        seen: list[Progress] = []
        try:
            resume_campaign(folder.path, engine, progress=seen.append)
            raise SystemExit("the disk was not full")
        except CampaignError as error:
            print(error, flush=True)
        after = len(folder.done())
        shutil.copytree(results, folder.path / "kept")
    finally:
        subprocess.run(["umount", str(results)], check=True)
    shutil.copytree(folder.path / "kept", results, dirs_exist_ok=True)
    resume_campaign(folder.path, engine)
    return outcome(name, FULL, folder, after, after, expected)


def kill_driver(process: "subprocess.Popen[bytes]", nodes: Cluster | None) -> None:
    """Kill the process that runs the campaign."""
    del nodes
    process.send_signal(signal.SIGKILL)


def kill_worker(process: "subprocess.Popen[bytes]", nodes: Cluster | None) -> None:
    """Kill a process that plans."""
    del nodes
    os.kill(workers({process.pid})[0], signal.SIGKILL)


def kill_actor(process: "subprocess.Popen[bytes]", nodes: Cluster | None) -> None:
    """Kill the actor that watches a worker."""
    del process, nodes
    actors = {pid for pid, line in processes() if line.startswith("ray::")}
    os.kill(parent(workers(actors)[0]), signal.SIGKILL)


def remove_node(process: "subprocess.Popen[bytes]", nodes: Cluster | None) -> None:
    """Take a node away."""
    del process
    assert nodes is not None
    os.kill(nodes.raylets()[-1], signal.SIGKILL)


def come_and_go(process: "subprocess.Popen[bytes]", nodes: Cluster | None) -> None:
    """Take a node away and start one, again and again while the campaign runs."""
    assert nodes is not None
    for _ in range(COMES):
        if process.poll() is not None:
            return
        remove_node(process, nodes)
        nodes.add()
        time.sleep(STAYS)


LOCAL_FAULTS: Mapping[str, Fault] = {
    "driver killed with -9": kill_driver,
    "worker killed with -9": kill_worker,
}
RAY_FAULTS: Mapping[str, Fault] = {
    "node removed": remove_node,
    "node comes and goes": come_and_go,
    "actor killed with -9": kill_actor,
    "driver killed with -9": kill_driver,
}


def begun(count: int, folder: Path) -> CampaignFolder:
    """Return a campaign that nothing is planned of yet."""
    return CampaignFolder.begin(campaign(count), folder)


def engine_of(address: str) -> Engine:
    """Return the engine at an address; this machine where there is none."""
    return Ray(address) if address else Local(WORKERS)


def rows_of(folder: CampaignFolder) -> dict[str, Any]:
    """Return the rows by id, without their times."""
    return {
        row["id"]: {name: item for name, item in row.items() if name not in TIMES} for row in folder.rows()
    }


def outcome(
    engine: str, fault: str, folder: CampaignFolder, before: int, after: int, expected: Mapping[str, Any]
) -> Outcome:
    """Return the outcome of a campaign."""
    rows = rows_of(folder)
    verified = sum(bool(row["verified"]) for row in rows.values())
    found = Outcome(engine, fault, before, after, folder.total, len(rows), rows == dict(expected), verified)
    print(found, flush=True)
    return found


if __name__ == "__main__":
    main()
