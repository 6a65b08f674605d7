"""SIGTERM: the server ends what it does, and says so to everybody, before it is gone."""

import json
import signal
import subprocess
import sys
import threading
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from typing import Any

import httpx
import pytest

from tests.server.test_hostile import PATIENCE
from trajopt.server.client import Client

SERVER = """
import asyncio
import trajopt as to
from tests.server.serving import MODULES, SMALL
from trajopt.cli.serve import http_face
from trajopt.server.http import HttpOptions, Metrics
from trajopt.server.service import run_faces

faces = [http_face(HttpOptions(port=0), Metrics())]
asyncio.run(run_faces({"planar2": to.load("planar2")}, faces, limits=SMALL, modules=MODULES))
"""


@contextmanager
def served_by_a_process() -> Generator[tuple[subprocess.Popen[str], str]]:
    """Yield a server of the tests' operations, and its address; it has to end well when it is told to."""
    with subprocess.Popen([sys.executable, "-uc", SERVER], stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            yield process, process.stdout.readline().split()[-1]
            assert process.wait(PATIENCE) == 0
        finally:
            process.kill()


def events(url: str, body: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield the events of a request."""
    headers = {"accept": "text/event-stream"}
    with httpx.stream("POST", url, json=body, headers=headers, timeout=PATIENCE) as answer:
        name = ""
        for line in answer.iter_lines():
            key, _, value = line.partition(": ")
            if key == "event":
                name = value
            elif key == "data":
                yield name, json.loads(value)


def test_a_driven_robot_is_stopped_and_its_client_notified() -> None:
    with served_by_a_process() as (process, url), Client(url) as client:
        session = client.session()
        goal = {"joint_positions": {"positions": {"joint1": 1.5, "joint2": 1.0}}}
        told = events(f"{url}/sessions/{session.id}/execute", {"problem": {"goal": goal}})
        assert next(told)[0] == "feedback"
        process.send_signal(signal.SIGTERM)
        *_, (name, last) = told
        assert name == "refusal"
        assert last["status"] == 503 and last["error"]["kind"] == "closing"
        assert "stopped the robot" in last["error"]["reason"]


def test_requests_are_refused_with_a_reason_until_the_robot_stops() -> None:
    with served_by_a_process() as (process, url), Client(url) as client:
        session = client.session()
        told = events(f"{url}/sessions/{session.id}/brake", {"to": [0.3, 0.1], "rest": [0.5, 0.2]})
        assert next(told)[0] == "feedback"
        ended = list[Any]()
        rest = threading.Thread(target=lambda: ended.extend(told))
        rest.start()
        process.send_signal(signal.SIGTERM)
        while httpx.get(f"{url}/health", timeout=PATIENCE).status_code == 200:
            pass
        for path in ("", f"/{session.id}/wait", f"/{session.id}/fork"):
            refused = httpx.post(f"{url}/sessions{path}", json={}, timeout=PATIENCE)
            assert refused.status_code == 503, path
            assert refused.json()["error"]["kind"] == "closing"
        rest.join(PATIENCE)
        assert ended[-1][0] == "refusal" and ended[-1][1]["error"]["kind"] == "closing"


@pytest.mark.parametrize("asked", ["wait", "stubborn"])
def test_a_request_that_does_not_end_in_time_is_refused(asked: str) -> None:
    with served_by_a_process() as (process, url), Client(url) as client:
        session = client.session()
        told = events(f"{url}/sessions/{session.id}/{asked}", {})
        assert next(told)[0] == "feedback"
        process.send_signal(signal.SIGTERM)
        assert [name for name, _ in told] == ["refusal"]
