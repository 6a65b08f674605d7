"""A worker has its next block before the first ends; whoever watches it never waits for it to listen."""

import os
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from io import BytesIO
from multiprocessing import Pipe
from pathlib import Path

import pyarrow.parquet as pq
import pytest

import trajopt as to
from trajopt.lab.campaign import Campaign, CampaignFolder, Local, ProblemSource, installed, random_motions
from trajopt.lab.campaign.campaign import CampaignTask
from trajopt.lab.campaign.engine import AHEAD, MARK, Block, PlannedBlock, StartReport
from trajopt.lab.campaign.supervisor import LETTERS, LocalPool, Worked, WorkerSupervisor, setup_of
from trajopt.lab.campaign.worker import BUNCH, serve
from trajopt.values.errors import CampaignError

pytestmark = pytest.mark.timeout(200)


@contextmanager
def watched(
    sources: list[ProblemSource], path: Path, most_seconds: float = 300.0
) -> Iterator[tuple[WorkerSupervisor, list[CampaignTask]]]:
    """Yield a worker, and the problems of a campaign that it does not have yet."""
    folder = CampaignFolder.begin(Campaign("x", sources, most_seconds=most_seconds), path)
    supervisor = WorkerSupervisor(setup_of(folder))
    try:
        yield supervisor, list(folder.tasks())
    finally:
        supervisor.close()


def next_of(supervisor: WorkerSupervisor) -> Worked:
    """Return what comes of the worker's first block."""
    while (worked := supervisor.advance()) is None:
        supervisor.pipe.poll(0.2)
    return worked


def ids(worked: Worked) -> list[str]:
    return [row["id"] for row in worked.rows]


def test_a_worker_starts_its_next_block_without_a_request(scene: to.Scene, tmp_path: Path) -> None:
    with watched([random_motions(scene, 2 * BUNCH + 2)], tmp_path) as (supervisor, tasks):
        supervisor.give(tasks[:2])
        supervisor.give(tasks[2:])
        assert ids(next_of(supervisor)) == [task.id for task in tasks[:2]]
        assert supervisor.pipe.poll(60.0)  # rows of the next block, for which nobody had to ask
        assert ids(next_of(supervisor)) == [task.id for task in tasks[2:]]
        assert supervisor.advance() is None


def test_more_problems_than_fit_into_one_message_have_their_rows(scene: to.Scene, tmp_path: Path) -> None:
    with watched([random_motions(scene, AHEAD + 9)], tmp_path) as (supervisor, tasks):
        assert ids(supervisor.run(tasks)) == [task.id for task in tasks]


def test_a_worker_that_is_killed_while_it_starts_is_started_once_more(
    scene: to.Scene, tmp_path: Path
) -> None:
    with watched([random_motions(scene, 3)], tmp_path) as (supervisor, tasks):
        supervisor._process.kill()
        assert ids(supervisor.run(tasks)) == [task.id for task in tasks]


def test_workers_that_are_always_killed_while_they_start_are_an_error(
    scene: to.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with watched([random_motions(scene, 3)], tmp_path) as (supervisor, tasks):
        start = WorkerSupervisor._start

        def killed(self: WorkerSupervisor) -> None:
            start(self)
            self._process.kill()

        monkeypatch.setattr(WorkerSupervisor, "_start", killed)
        supervisor._process.kill()
        with pytest.raises(CampaignError, match=r"before it was ready \(signal SIGKILL\)"):
            supervisor.run(tasks)


def test_a_worker_that_ends_leaves_both_blocks_to_the_next(
    faulty: Path, scene: to.Scene, tmp_path: Path
) -> None:
    with watched([installed("ends"), random_motions(scene, 4)], tmp_path) as (supervisor, tasks):
        supervisor.give(tasks[:2])
        supervisor.give(tasks[2:])
        first, second = next_of(supervisor), next_of(supervisor)
        assert [row["status"] for row in first.rows] == ["CRASHED", "SOLVED"]
        assert ids(second) == [task.id for task in tasks[2:]]


def test_a_worker_that_ends_amid_problems_costs_none_of_those_before_and_behind(
    faulty: Path, scene: to.Scene, tmp_path: Path
) -> None:
    sources = [random_motions(scene, 5), installed("ends"), random_motions(scene, 9, seed=1)]
    with watched(sources, tmp_path) as (supervisor, tasks):
        worked = supervisor.run(tasks)
        assert ids(worked) == [task.id for task in tasks]
        assert [row["status"] for row in worked.rows] == ["SOLVED"] * 5 + ["CRASHED"] + ["SOLVED"] * 9


def test_only_the_hanging_problem_is_given_up_not_unreported_rows(
    faulty: Path, scene: to.Scene, tmp_path: Path
) -> None:
    sources = [random_motions(scene, 5), installed("hangs"), random_motions(scene, 4, seed=1)]
    with watched(sources, tmp_path, 6.0) as (supervisor, tasks):
        worked = supervisor.run(tasks)
        assert ids(worked) == [task.id for task in tasks]
        assert [row["status"] for row in worked.rows] == ["SOLVED"] * 5 + ["RAN_OVER"] + ["SOLVED"] * 4
        assert worked.rows[5]["wall_seconds"] > 6.0


@pytest.mark.parametrize(("seconds", "at_once"), [(1e9, [BUNCH, BUNCH, 3]), (-1.0, [1] * (2 * BUNCH + 3))])
def test_a_worker_sends_rows_in_batches_or_after_a_timeout(
    scene: to.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seconds: float, at_once: list[int]
) -> None:
    monkeypatch.setattr("trajopt.lab.campaign.worker.BUNCH_SECONDS", seconds)
    folder = CampaignFolder.begin(Campaign("x", [random_motions(scene, sum(at_once))]), tmp_path)
    mine, its = Pipe()
    read, written = os.pipe()
    with ThreadPoolExecutor(1) as pool, its, open(read, "rb") as marks, open(written, "wb"):
        with mine:
            served = pool.submit(serve, its, written)
            mine.send(setup_of(folder))
            mine.send(list(folder.tasks()))
            assert mine.recv() == StartReport()
            told = [mine.recv() for _ in at_once]
        served.result()  # it ends with the pipe
        assert [len(each.rows) for each in told] == at_once
        assert [row["id"] for each in told for row in each.rows] == [task.id for task in folder.tasks()]
        begun = [MARK.unpack(marks.read(MARK.size))[0] for _ in range(sum(at_once))]
        assert begun == list(range(1, sum(at_once) + 1))


def test_who_watches_a_worker_that_hangs_is_not_held_up_by_long_recipes(
    faulty: Path, scene: to.Scene, tmp_path: Path
) -> None:
    with watched([installed("hangs"), random_motions(scene, 3)], tmp_path, 6.0) as (supervisor, tasks):
        long = [replace(each, recipe=each.recipe + " " * 40 * LETTERS) for each in tasks[1:]]
        supervisor.give(tasks[:1])
        supervisor.give(long)  # what has no room in the socket is sent when the worker listens
        assert [row["status"] for row in next_of(supervisor).rows] == ["RAN_OVER"]
        assert ids(next_of(supervisor)) == [task.id for task in long]


def test_each_worker_of_this_machine_takes_two_blocks(scene: to.Scene, tmp_path: Path) -> None:
    folder = CampaignFolder.begin(Campaign("x", [random_motions(scene, 4)]), tmp_path)
    with Local(2).pool(folder) as pool:
        assert isinstance(pool, LocalPool)
        blocks = [Block([task]) for task in folder.tasks()]
        for count, block in enumerate(blocks):
            assert pool.idle == 4 - count
            pool.submit(block)
        assert pool.idle == 0
        ended: list[PlannedBlock] = []
        while len(ended) < 4:
            ended += [each for each in pool.wait(1.0) if isinstance(each, PlannedBlock)]
        assert {id(each.block) for each in ended} == set(map(id, blocks)) and pool.idle == 4
        tables = [pq.read_table(BytesIO(each.shard)) for each in ended]
        assert sorted(Counter(table["process"][0].as_py() for table in tables).values()) == [2, 2]


def test_blocks_that_end_with_the_same_rows_are_both_returned(scene: to.Scene, tmp_path: Path) -> None:
    folder = CampaignFolder.begin(Campaign("x", [random_motions(scene, 2)]), tmp_path)
    with Local(1).pool(folder) as pool:
        for task in folder.tasks():
            pool.submit(Block([task]))
        ended = 0
        while ended < 2:
            ended += len(pool.wait(1.0))
