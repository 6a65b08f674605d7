"""Many requests at once: all are answered, and a process that is killed takes only its own with it."""

import asyncio
import os
import signal
from collections import Counter

import pytest

from tests.server.serving import serving
from trajopt.server import Lane, Limits
from trajopt.server.client import AsyncClient, AsyncSession, ServerError

REACH = {"goal": {"joint_positions": {"positions": {"joint1": 0.4, "joint2": 0.3}}}}


@pytest.mark.slow
def test_of_a_thousand_requests_only_those_of_a_killed_process_fail() -> None:
    limits = Limits(workers=2, waiting=16, grace=0.5)
    with serving("planar2", limits=limits) as server:
        pool = server.service.pools[Lane.PLANNING]
        ended, left = Counter[str](), iter(range(1000))

        async def ask(session: AsyncSession) -> None:
            for number in left:
                if number == 500:
                    os.kill(pool.pids[0], signal.SIGKILL)
                try:
                    answer = await session.plan(REACH)
                    ended["verified" if answer["verified"] else "no plan"] += 1
                except ServerError as error:
                    assert error.reason
                    ended[error.kind] += 1

        async def run() -> None:
            async with AsyncClient(server.url, patience=300.0) as client:
                sessions = [await client.session() for _ in range(5)]
                await asyncio.gather(*(ask(sessions[i % 5]) for i in range(40)))

        asyncio.run(run())
        assert ended.total() == 1000
        assert ended.keys() <= {"verified", "worker lost"}
        assert ended["worker lost"] <= 1
        assert pool.restarts == 1
        assert b'outcome="full"' in server.metrics.text()
