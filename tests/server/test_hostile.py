"""Requests that are malformed or mean harm: answered with a reason or cut off, and the server serves on."""

import json
import socket
import time
from collections.abc import Iterator
from dataclasses import replace

import httpx
import pytest

from tests.server.hostile import Hostile, hostile, raw
from tests.server.serving import PATIENT, SMALL, Serving, serving
from trajopt.server import Lane
from trajopt.server.client import Client
from trajopt.server.http import HttpOptions

ALL = list(hostile())
FEW = ALL[::7]
PATIENCE = 4.0 * PATIENT.transfer + 20.0


def sent(server: Serving, request: bytes) -> tuple[int, bytes]:
    """Send bytes and return the status and the body of what comes back; 0 where it is cut off."""
    with socket.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as connection:
        try:
            connection.sendall(request)
        except (BrokenPipeError, ConnectionResetError):
            pass  # cut off while it was sent; the answer may be there all the same
        return received(connection)


def received(connection: socket.socket) -> tuple[int, bytes]:
    answer = b""
    try:
        while b"\r\n\r\n" not in answer or len(body(answer)) < length(answer):
            part = connection.recv(65536)
            if not part:
                break
            answer += part
    except ConnectionResetError:
        pass
    return (int(answer.split()[1]) if answer else 0), body(answer)


def body(answer: bytes) -> bytes:
    return answer.partition(b"\r\n\r\n")[2]


def length(answer: bytes) -> int:
    head = answer.partition(b"\r\n\r\n")[0].lower()
    return int(head.partition(b"content-length: ")[2].split(b"\r\n")[0] or b"0")


def serves(server: Serving) -> None:
    with Client(server.url) as client, client.session() as session:
        goal = {"joint_positions": {"positions": {"joint1": 0.4, "joint2": 0.3}}}
        assert session.plan({"goal": goal})["verified"]


def turned_away(server: Serving, session: str, request: Hostile) -> None:
    status, answer = sent(server, request.make(session))
    assert b"root:" not in answer
    if status == 0:
        assert request.cut, f"{request.name}: cut off without a word"
        return
    assert 400 <= status < 500, f"{request.name}: {status} {answer[:300]!r}"
    if not request.cut and b"Invalid HTTP" not in answer:
        assert answer.startswith(b'{"error":'), f"{request.name}: {status} {answer[:300]!r}"
        error = json.loads(answer)["error"]
        assert error["kind"] and error["reason"], request.name


@pytest.fixture(scope="module")
def session(server: Serving) -> Iterator[str]:
    with Client(server.url) as client, client.session() as begun:
        yield begun.id


@pytest.mark.parametrize("request_sent", FEW, ids=lambda each: each.name[:60])
def test_a_hostile_request_is_turned_away(server: Serving, session: str, request_sent: Hostile) -> None:
    turned_away(server, session, request_sent)


@pytest.mark.slow
def test_all_hostile_requests_are_turned_away_and_the_server_serves_on(server: Serving, session: str) -> None:
    assert len(ALL) >= 100
    lanes = (Lane.PLANNING, Lane.QUICK)
    before = [server.service.pools[lane].pids for lane in lanes]
    failed: list[str] = []
    for request in ALL:
        try:
            turned_away(server, session, request)
        except AssertionError as error:
            failed.append(str(error).splitlines()[0])
    assert failed == []
    serves(server)
    assert [server.service.pools[lane].pids for lane in lanes] == before


def test_half_open_sockets_and_slow_bodies_are_cut_off_and_do_not_keep_others_out(
    server: Serving, session: str
) -> None:
    silent = [socket.create_connection(("127.0.0.1", server.port)) for _ in range(40)]
    slow = socket.create_connection(("127.0.0.1", server.port))
    try:
        slow.sendall(b"POST /sessions HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n")
        slow.sendall(b"Content-Length: 1000\r\n\r\n{")
        serves(server)
        for connection in silent:
            connection.settimeout(PATIENCE)
            assert connection.recv(1) == b""
        slow.settimeout(PATIENCE)
        assert received(slow)[0] == 408
    finally:
        for connection in (*silent, slow):
            connection.close()


def test_a_body_that_trickles_on_after_its_refusal_is_cut_off(server: Serving) -> None:
    with socket.create_connection(("127.0.0.1", server.port)) as slow:
        slow.sendall(b"POST /sessions HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n")
        slow.sendall(b"Content-Length: 1000\r\n\r\n{")
        slow.settimeout(PATIENCE)
        assert received(slow)[0] == 408
        for _ in range(500):
            time.sleep(0.02)
            try:
                slow.sendall(b" ")
            except OSError:
                break
        else:
            pytest.fail("the server listens on")
    serves(server)


def test_requests_under_way_have_room_for_so_many_bytes_together() -> None:
    half = replace(SMALL, body=2**20, bodies=2**20)
    patient = HttpOptions(port=0, transfer=PATIENCE)
    with serving(limits=half, options=patient) as server, Client(server.url) as client:
        session = client.session()
        head = raw(f"/sessions/{session.id}/wait", b" " * 700_000)
        url, until = f"{server.url}/sessions/{session.id}/wait", time.monotonic() + PATIENCE

        def until_it_is(status: int) -> httpx.Response:
            while time.monotonic() < until:
                answer = httpx.post(url, json={"seconds": 0.0, "more": "x" * 500_000}, timeout=PATIENCE)
                if answer.status_code == status:
                    return answer
            pytest.fail(f"none was answered with {status}")

        with socket.create_connection(("127.0.0.1", server.port)) as holding:
            holding.sendall(head[:-1])
            refused = until_it_is(429)
            assert "together" in refused.json()["error"]["reason"] and refused.headers["retry-after"] == "1"
            assert client.session().read()["robot"] == "planar2", "small ones have room"
        until_it_is(200)


def test_more_connections_than_there_may_be_are_cut_off(server: Serving) -> None:
    many = [socket.create_connection(("127.0.0.1", server.port)) for _ in range(PATIENT.connections + 20)]
    for connection in many:
        connection.close()
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        try:
            assert httpx.get(f"{server.url}/health", timeout=PATIENCE).status_code == 200
            return
        except httpx.TransportError:
            time.sleep(0.05)
    pytest.fail("the server does not serve any more")


def test_a_client_that_goes_away_has_its_request_cancelled(server: Serving, session: str) -> None:
    pool = server.service.pools[Lane.PLANNING]
    connection = socket.create_connection(("127.0.0.1", server.port))
    connection.sendall(raw(f"/sessions/{session}/wait", b"{}"))
    until = time.monotonic() + PATIENCE
    while not pool.busy and time.monotonic() < until:
        time.sleep(0.02)
    connection.close()
    while pool.busy and time.monotonic() < until:
        time.sleep(0.02)
    assert not pool.busy
    serves(server)
