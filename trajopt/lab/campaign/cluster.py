"""Ray: the engine that plans on the machines of a cluster."""

import logging
import os
import time
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from trajopt.lab.campaign.campaign import CampaignTask
from trajopt.lab.campaign.engine import AHEAD, Block, EnginePool, Lost, PlannedBlock, Setup, check_workers
from trajopt.lab.campaign.kept import CampaignFolder
from trajopt.lab.campaign.recipes import sent_from
from trajopt.lab.campaign.supervisor import WorkerSupervisor, planned, setup_of
from trajopt.values.errors import CampaignError, MissingExtra
from trajopt.values.errors.arguments import checked
from trajopt.values.processes import cores

POLL = 2.0
"""Period of checks for nodes that came or left [s]; Ray itself notices within some seconds."""
PATIENCE = 300.0
"""Longest wait for the first worker of a cluster [s]; nodes of a cloud take minutes."""


@checked
@dataclass(frozen=True)
class Ray:
    """Workers on the machines of a Ray cluster; each needs the same trajopt installed.

    Attributes:
        address: Of a running cluster, such as "10.0.0.1:6379", or "auto" on one of its machines; if empty, a
            cluster is started on this machine.
    """

    address: str = ""
    workers: int = 0

    def __post_init__(self) -> None:
        check_workers(self.workers)

    @contextmanager
    def pool(self, folder: CampaignFolder) -> Generator[EnginePool]:
        if find_spec("ray") is None:
            raise MissingExtra("ray", "ray")
        ray: Any = import_module("ray")
        started = not ray.is_initialized()
        if started:
            self._connect(ray)
        try:
            workers = RayPool(
                ray, replace(setup_of(folder), documents=sent_from(folder.documents)), self.workers
            )
            try:
                yield workers
            finally:
                workers.close()
        finally:
            if started:
                ray.shutdown()

    def _connect(self, ray: Any) -> None:
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # nothing is told to anybody unasked
        quiet: dict[str, Any] = {"log_to_driver": False, "logging_level": logging.ERROR}
        try:
            if self.address:
                ray.init(address=self.address, **quiet)
            else:
                ray.init(address="local", num_cpus=self.workers or cores(), include_dashboard=False, **quiet)
        except (ConnectionError, RuntimeError, ValueError) as error:
            raise CampaignError(f"no cluster of Ray at {self.address or 'this machine'}: {error}") from error


class Planner:
    """An actor: one worker process, watched."""

    def __init__(self, setup: Setup) -> None:
        self._supervisor = WorkerSupervisor(setup)

    def ready(self) -> None:
        """Do nothing: an answer shows that the actor is there."""

    def plan(self, tasks: Sequence[CampaignTask]) -> PlannedBlock:
        return planned(Block(()), self._supervisor.run(tasks))


class RayPool:
    """Actors of a cluster, as many as it has cores at the time."""

    def __init__(self, ray: Any, setup: Setup, most: int) -> None:
        self._ray, self._most = ray, most
        self._setup = ray.put(setup)
        self._kind = ray.remote(num_cpus=1, max_restarts=0, max_task_retries=0)(Planner)
        self._actors: list[Any] = []
        self._starting: dict[Any, Any] = {}
        self._free: list[Any] = []  # each as often as it can take a block
        self._busy: dict[Any, tuple[Any, Block]] = {}
        self._cores, self._looked, self._alive = 0, 0.0, time.monotonic()
        self._grow()

    @property
    def workers(self) -> int:
        return max(1, min(self._most or self._cores, self._cores))

    @property
    def idle(self) -> int:
        return len(self._free)

    def submit(self, block: Block) -> None:
        actor = self._free.pop(0)
        self._busy[actor.plan.remote(list(block.tasks))] = actor, block

    def wait(self, seconds: float) -> Sequence[PlannedBlock | Lost]:
        self._grow()
        running = [*self._starting, *self._busy]
        if not running:
            time.sleep(seconds)
            return []
        first, rest = self._ray.wait(running, num_returns=1, timeout=seconds)
        more, _ = self._ray.wait(rest, num_returns=len(rest), timeout=0.0) if rest else ((), ())
        return [each for future in (*first, *more) for each in self._ended(future)]

    def close(self) -> None:
        for actor in self._actors:
            self._ray.kill(actor)

    def _grow(self) -> None:
        now = time.monotonic()
        if self._free or self._busy:
            self._alive = now
        if now - self._alive > PATIENCE:
            raise CampaignError(f"no machine of the cluster had a free core for {PATIENCE:g} s")
        if now - self._looked < POLL:
            return
        self._looked, self._cores = now, int(self._ray.cluster_resources().get("CPU", 0))
        for _ in range(self.workers - len(self._actors) if self._cores else 0):
            actor = self._kind.remote(self._setup)
            self._actors.append(actor)
            self._starting[actor.ready.remote()] = actor

    def _ended(self, future: Any) -> Sequence[PlannedBlock | Lost]:
        if future in self._starting:
            actor = self._starting.pop(future)
            _, why = self._told(future, actor)
            if not why:
                self._free = [actor, *self._free, *[actor] * (AHEAD - 1)]
            return ()
        if future not in self._busy:
            return ()
        actor, _ = self._busy[future]
        told, why = self._told(future, actor)
        if why:
            his = [future for future, (each, _) in self._busy.items() if each is actor]
            blocks = [self._busy.pop(future)[1] for future in his]
            return [Lost(block, why, begun=place == 0) for place, block in enumerate(blocks)]
        _, block = self._busy.pop(future)
        at_work = any(each is actor for each, _ in self._busy.values())
        self._free.insert(len(self._free) if at_work else 0, actor)
        return (replace(told, block=block),)

    def _told(self, future: Any, actor: Any) -> tuple[Any, str]:
        errors = self._ray.exceptions
        try:
            return self._ray.get(future), ""
        except errors.RayTaskError as error:
            if isinstance(error.cause, CampaignError):
                raise error.cause from error
            raise CampaignError(f"a worker failed: {error.cause!r}") from error
        except errors.RayError as error:
            self._free = [each for each in self._free if each is not actor]
            if actor in self._actors:
                self._actors.remove(actor)
                self._ray.kill(actor)
            return None, f"{type(error).__name__}: {_first_line(error)}"


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [""])[0]
