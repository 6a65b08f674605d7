"""Machines of a cluster that come and go: every problem has its row, and only the guilty one is given up.

The cluster is played: what its actors plan is planned here, and a script says when one is lost.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests.lab.campaign.rooms import rows_of
from trajopt.lab.campaign import Campaign, CampaignFolder, Progress, resume_campaign
from trajopt.lab.campaign.campaign import CampaignTask
from trajopt.lab.campaign.cluster import RayPool
from trajopt.lab.campaign.engine import Block, EnginePool, PlannedBlock, Setup
from trajopt.lab.campaign.recipes import Library, Workshop
from trajopt.lab.campaign.row import row_of
from trajopt.lab.campaign.supervisor import Worked, setup_of
from trajopt.lab.campaign.supervisor import planned as planned_block


class ActorLost(Exception):
    """What Ray says of an actor whose machine is gone."""


class Failed(Exception):
    """What Ray says of an actor that raised."""


@dataclass(eq=False)
class Actor:
    """An actor of the played cluster: what it was asked, in order, until it is lost."""

    cluster: "Played"
    futures: list["Future"] = field(default_factory=list["Future"])
    lost: bool = False

    def __post_init__(self) -> None:
        self.ready = SimpleNamespace(remote=lambda: self.asked(None))
        self.plan = SimpleNamespace(remote=self.asked)

    def asked(self, tasks: list[CampaignTask] | None) -> "Future":
        self.futures.append(Future(self, tasks))
        return self.futures[-1]


@dataclass(eq=False)
class Future:
    """What an actor will answer."""

    actor: Actor
    tasks: list[CampaignTask] | None
    answer: PlannedBlock | None = None
    done: bool = False


class Played:
    """A cluster of Ray as far as a pool of actors needs it.

    Args:
        loses: Whether the machine of an actor is lost under a block.
    """

    def __init__(self, folder: CampaignFolder, loses: Callable[[Sequence[CampaignTask]], bool]) -> None:
        self._loses, self._options = loses, folder.options
        self._shop = Workshop(Library(folder.documents))
        self.exceptions = SimpleNamespace(RayError=ActorLost, RayTaskError=Failed)
        self.kill = lambda actor: setattr(actor, "lost", True)
        self.cores = 2

    def put(self, value: Setup) -> Setup:
        return value

    def remote(self, **asked: int) -> Callable[[type], Any]:
        assert asked == {"num_cpus": 1, "max_restarts": 0, "max_task_retries": 0}
        return lambda kind: SimpleNamespace(remote=lambda setup: Actor(self))

    def cluster_resources(self) -> dict[str, float]:
        return {"CPU": float(self.cores)}

    def wait(self, futures: list[Future], **asked: Any) -> tuple[list[Future], list[Future]]:
        """Have each actor go on with what it was asked first; what ended comes last first."""
        for actor in {id(each.actor): each.actor for each in futures}.values():
            self._go_on(actor)
        ended = [each for each in futures if each.done or each.actor.lost]
        return ended[: -asked["num_returns"] - 1 : -1], [each for each in futures if each not in ended]

    def get(self, future: Future) -> PlannedBlock | None:
        if not future.done:
            raise ActorLost("its machine is gone\nand more")
        return future.answer

    def _go_on(self, actor: Actor) -> None:
        if actor.lost or not actor.futures:
            return
        future = actor.futures[0]
        if future.tasks is not None and self._loses(future.tasks):
            actor.lost = True
            return
        actor.futures.pop(0)
        if future.tasks is not None:
            rows = [row_of(task, self._options[task.options], self._shop) for task in future.tasks]
            future.answer = planned_block(Block(()), Worked(rows, 0.0))
        future.done = True


@dataclass(frozen=True)
class PlayedEngine:
    """Plans on the played cluster."""

    loses: Callable[[Sequence[CampaignTask]], bool]

    @contextmanager
    def pool(self, folder: CampaignFolder) -> Iterator[EnginePool]:
        yield RayPool(Played(folder, self.loses), setup_of(folder), 0)


@pytest.fixture
def begun(small: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> CampaignFolder:
    """The small campaign, of which nothing is planned; whoever plans it looks for machines all the time."""
    monkeypatch.setattr("trajopt.lab.campaign.cluster.POLL", 0.0)
    return CampaignFolder.begin(small, tmp_path)


def test_machines_that_come_and_go_often_cost_no_row(begun: CampaignFolder, planned: CampaignFolder) -> None:
    left = 12

    def loses(tasks: Sequence[CampaignTask]) -> bool:
        nonlocal left
        left -= 1
        return left >= 0

    said: list[Progress] = []
    resume_campaign(begun.path, PlayedEngine(loses), progress=said.append)
    assert said[-1].losses == 12 and rows_of(begun) == rows_of(planned)


def test_only_the_problem_that_takes_its_machine_down_is_given_up(
    begun: CampaignFolder, planned: CampaignFolder
) -> None:
    guilty = list(begun.tasks())[5].id
    resume_campaign(begun.path, PlayedEngine(lambda tasks: guilty in {task.id for task in tasks}))
    rows, expected = rows_of(begun), rows_of(planned)
    lost = rows.pop(guilty)
    assert lost["status"] == "CRASHED" and "ActorLost: its machine is gone)" in lost["message"]
    assert rows == {key: row for key, row in expected.items() if key != guilty}
