"""What HTTP sees beside the operations: health, numbers, pages, who is let in, and the end."""

import asyncio
import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import httpx
import pytest

import trajopt as to
from tests.ros.commander.conftest import SRDF, URDF
from tests.server.serving import SMALL, Serving, serving
from tests.server.test_service import served
from trajopt.cli.options import sources_of
from trajopt.cli.serve import loaded
from trajopt.server import Service
from trajopt.server.client import Client, ServerError, Session
from trajopt.server.http import HttpOptions, http_app

TOKEN = "a token of sixteen or more"
POST = {"content-type": "application/json"}


def test_health_and_numbers(server: Serving) -> None:
    health = httpx.get(f"{server.url}/health")
    assert health.json() == {"healthy": True, "workers": 1}
    with Client(server.url) as client, client.session() as session:
        session.read()
    numbers = httpx.get(f"{server.url}/metrics").text
    assert 'trajopt_requests_total{operation="read",outcome="answered"}' in numbers
    assert 'trajopt_workers{lane="planning"} 1.0' in numbers
    memory = re.search(r'trajopt_memory_bytes\{lane="planning"\} (\S+)', numbers)
    assert memory is not None and float(memory[1]) > 1e7


def test_everything_that_can_be_asked_is_described_and_no_page_needs_another_server(server: Serving) -> None:
    described = httpx.get(f"{server.url}/openapi.json").json()
    for operation in ("plan", "edit", "execute", "follow", "check", "explain"):
        assert described["paths"][f"/sessions/{{session}}/{operation}"]["post"]["description"]
    for path in ("/", "/docs", "/page.js", "/page.css"):
        page = httpx.get(f"{server.url}{path}")
        assert page.status_code == 200
        assert "default-src 'self'" in page.headers["content-security-policy"]
        assert not re.search(r"https?://(?!localhost)", page.text), path


@pytest.mark.parametrize(
    ("method", "path", "taken"), [("PUT", "/sessions", "POST"), ("POST", "/robots", "GET")]
)
def test_names_the_methods_of_an_address(server: Serving, method: str, path: str, taken: str) -> None:
    answer = httpx.request(method, f"{server.url}{path}")
    assert answer.status_code == 405 and answer.headers["allow"] == taken
    assert answer.json()["error"]["reason"] == f"this address takes {taken}, not {method}"


def test_the_robot_list_contains_the_fields_a_client_needs(server: Serving) -> None:
    robot = httpx.get(f"{server.url}/robots").json()[0]
    assert robot["name"] == "planar2"
    assert robot["joints"]["joint1"].keys() == {"lower", "upper", "velocity", "acceleration"}


def test_a_full_server_reports_when_to_retry(server: Serving) -> None:
    from trajopt.server.http.answers import refusal_response
    from trajopt.server.limits import RequestRefused, Why

    response = refusal_response(RequestRefused(Why.FULL, "full", retry_after=0.25))
    assert response.status_code == 429
    assert response.headers["retry-after"] == "1"
    assert response.headers["x-retry-after"] == "0.250"


def test_refuses_one_of_two_concurrent_requests_with_the_same_name() -> None:
    async def test(service: Service) -> None:
        transport = httpx.ASGITransport(http_app(service))
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            session = (await client.post("/sessions", json={})).json()["session"]
            asked = [
                client.post(
                    f"/sessions/{session}/wait", json={"seconds": 0.2}, headers={"x-request-name": "mine"}
                )
                for _ in range(2)
            ]
            answers = await asyncio.gather(*asked)
            assert sorted(each.status_code for each in answers) == [200, 409]
            again = await client.post(
                f"/sessions/{session}/wait", json={"seconds": 0.0}, headers={"x-request-name": "mine"}
            )
            assert again.status_code == 200

    served(test)


def test_the_server_requires_a_token() -> None:
    with serving(options=HttpOptions(port=0, token=TOKEN)) as server:
        assert httpx.get(f"{server.url}/health").status_code == 200
        assert httpx.get(f"{server.url}/robots").status_code == 401
        for header in ("Bearer wrong", TOKEN, f"Basic {TOKEN}", "Bearer", "Bearer é"):
            headers = {b"authorization": header.encode()}
            assert httpx.get(f"{server.url}/robots", headers=headers).status_code == 401
        with pytest.raises(ServerError, match="token"), Client(server.url) as client:
            client.session()
        with Client(server.url, token=TOKEN) as client, client.session() as session:
            assert session.read()["robot"] == "planar2"


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.1.1", "::", "myhost"])
def test_other_machines_are_not_let_in_without_a_token(host: str) -> None:
    with pytest.raises(to.TrajoptError, match="token"):
        HttpOptions(host=host)
    HttpOptions(host=host, token=TOKEN)
    with pytest.raises(to.TrajoptError, match="16"):
        HttpOptions(token="short")


def test_pages_of_other_sites_are_kept_out(server: Serving) -> None:
    for name, value, status in (
        ("origin", "http://evil.example", 403),
        ("origin", "null", 403),
        ("origin", server.url, 201),
        ("host", "evil.example", 421),
        ("host", f"localhost:{server.port}", 201),
    ):
        answer = httpx.post(f"{server.url}/sessions", headers={**POST, name: value}, json={})
        assert answer.status_code == status, (name, value)


def test_the_command_serves_logs_and_ends(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "trajopt",
        "serve",
        "--robot",
        "planar2",
        "--port",
        "0",
        "--workers",
        "1",
    ]
    with (tmp_path / "log").open("w") as log:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True, env=os.environ)
        assert process.stdout is not None
        try:
            url = process.stdout.readline().split()[-1]
            with Client(url) as client, client.session() as session:
                session.read()
                with pytest.raises(ServerError):
                    session.plan({"gaol": {}})
            process.send_signal(signal.SIGTERM)
            assert process.wait(30.0) == 0
        finally:
            process.kill()
            process.stdout.close()
            process.wait()
    lines = [json.loads(line) for line in (tmp_path / "log").read_text().splitlines()]
    requests = [line for line in lines if line["event"] == "request"]
    assert [line["outcome"] for line in requests] == ["answered", "malformed"]
    assert all(len(line["session"]) == 6 for line in requests)


@pytest.mark.parametrize(
    ("robot", "ending"),
    [
        ("planar2", signal.SIGKILL),
        pytest.param("panda", signal.SIGKILL, marks=pytest.mark.slow),
        pytest.param("panda", signal.SIGTERM, marks=pytest.mark.slow),
        pytest.param("ur5", signal.SIGKILL, marks=pytest.mark.slow),
    ],
)
def test_sessions_survive_the_end_of_the_server(robot: str, ending: signal.Signals, tmp_path: Path) -> None:
    """Also with an edit under way: all that were answered are there, and at most the one that was not."""
    kept = ["--warehouse", str(tmp_path / "cell.warehouse")]
    command = [sys.executable, "-m", "trajopt", "serve", "--robot", robot, "--port", "0", *kept]
    place = {"xyz": [0.75, -0.4, 0.14]}
    name, answered = "", list[str]()

    def edit(session: Session) -> None:
        with contextlib.suppress(ServerError):
            for count in range(1000):
                ball = {"name": f"ball {count}", "shape": {"sphere": {"radius": 0.01}}, "placement": place}
                session.edit([{"add": ball}])
                answered.append(f"ball {count}")

    for _ in range(2):
        with subprocess.Popen(
            [*command, "--workers", "1"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        ) as process:
            assert process.stdout is not None
            try:
                with Client(process.stdout.readline().split()[-1]) as client:
                    if not name:
                        session = client.session()
                        name = session.id
                        editing = threading.Thread(target=edit, args=(session,))
                        editing.start()
                        while len(answered) < 5:
                            time.sleep(0.01)
                        process.send_signal(ending)
                        editing.join()
                    else:
                        found = list(client.resume(name).read()["objects"])
                        assert found[: len(answered)] == answered and len(found) <= len(answered) + 1
            finally:
                process.kill()


def test_files_beside_are_those_of_the_description_and_not_of_installed_robots(tmp_path: Path) -> None:
    urdf, srdf = tmp_path / "arm.urdf", tmp_path / "arm.srdf"
    urdf.write_text(URDF)
    srdf.write_text(SRDF)
    sources = sources_of(["planar2", str(urdf)], srdf=srdf, limits=None, package_dirs=(tmp_path,))
    robots = loaded(sources)
    first, second = robots.items()
    assert first[0] == "planar2" and "arm" in second[1].groups
    with pytest.raises(to.TrajoptError, match="brings its own files"):
        loaded(sources_of(["planar2"], srdf=srdf, limits=None))
    with pytest.raises(to.TrajoptError, match="of one robot"):
        sources_of([str(urdf), str(urdf)], srdf=srdf, limits=None)


def test_the_command_refuses_to_be_open(capfd: pytest.CaptureFixture[str]) -> None:
    command = [sys.executable, "-m", "trajopt", "serve", "--robot", "planar2", "--host", "0.0.0.0"]
    environment = {key: value for key, value in os.environ.items() if key != "TRAJOPT_TOKEN"}
    done = subprocess.run(command, capture_output=True, text=True, timeout=60.0, env=environment, check=False)
    assert done.returncode == 2
    assert "token" in done.stderr and "Traceback" not in done.stderr


def test_the_limits_of_the_tests_are_smaller_than_those_of_everybody() -> None:
    assert SMALL.body < type(SMALL)().body


@pytest.mark.parametrize("option", ["--port", "--rosbridge-port", "--mesh-port"])
def test_a_port_that_does_not_exist_is_refused(option: str) -> None:
    command = [sys.executable, "-m", "trajopt", "serve", "--robot", "planar2", "--port", "0"]
    done = subprocess.run(
        [*command, option, "99999"], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 2 and "65535" in done.stderr and "Traceback" not in done.stderr
