"""A page opens by its own address only; foreign pages and other host names are refused."""

import socket
from collections.abc import Generator
from http import HTTPStatus
from urllib.parse import urlsplit

import httpx
import pytest

pytest.importorskip("viser")
import viser
from viser import ViserServer
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Subprotocol

import trajopt as to
from trajopt.viewer.guarded_server import GuardedServer, _asking
from trajopt.viewer.server import close_server, open_server

VERSION = Subprotocol(f"viser-v{viser.__version__}")


@pytest.fixture(scope="module")
def page() -> Generator[GuardedServer]:
    server = open_server("127.0.0.1", 0)
    yield server
    close_server(server)


def first_bytes(page: GuardedServer, path: str, **headers: str) -> bytes:
    at = urlsplit(page.address)
    with connect(
        f"ws://{at.netloc}{path}", subprotocols=[VERSION], additional_headers=headers, max_size=2**24
    ) as socket:
        message = socket.recv(timeout=10.0)
        assert isinstance(message, bytes)
        return message


def test_its_own_window_receives_the_scene(page: GuardedServer) -> None:
    at = urlsplit(page.address)
    assert first_bytes(page, at.path, Origin=f"http://{at.netloc}")
    assert first_bytes(page, at.path.rstrip("/")), "programs send no Origin"
    assert httpx.get(page.address).status_code == HTTPStatus.OK


@pytest.mark.parametrize("origin", ["http://evil.example", "http://localhost:1", "null", "https://127.0.0.1"])
def test_a_foreign_origin_is_refused(page: GuardedServer, origin: str) -> None:
    path = urlsplit(page.address).path
    with pytest.raises(InvalidStatus) as refused:
        first_bytes(page, path, Origin=origin)
    assert refused.value.response.status_code == HTTPStatus.FORBIDDEN
    assert httpx.get(page.address, headers={"Origin": origin}).status_code == HTTPStatus.FORBIDDEN


@pytest.mark.parametrize("path", ["/", "/wrong/", "", "//", "/%2e%2e/", "/?secret"])
def test_without_the_secret_nothing_is_served(page: GuardedServer, path: str) -> None:
    with pytest.raises(InvalidStatus) as refused:
        first_bytes(page, path or "/")
    assert refused.value.response.status_code == HTTPStatus.FORBIDDEN
    answer = httpx.get(f"http://{urlsplit(page.address).netloc}{path}")
    assert answer.status_code == HTTPStatus.FORBIDDEN and "holds a secret" in answer.text


def test_another_name_of_this_machine_is_refused(page: GuardedServer) -> None:
    answer = httpx.get(page.address, headers={"Host": "evil.example"})
    assert answer.status_code == HTTPStatus.MISDIRECTED_REQUEST


@pytest.mark.parametrize(
    ("request_line", "headers", "status"),
    [
        (b"GET /\xff HTTP/1.1", (b"Host: localhost",), HTTPStatus.FORBIDDEN),
        (b"GET / HTTP/1.1", (b"Host: localhost", b"Host: localhost"), HTTPStatus.BAD_REQUEST),
        (b"GET / HTTP/1.1", (), HTTPStatus.BAD_REQUEST),
        (b"GET / HTTP/1.1", (b"Host: [::1",), HTTPStatus.MISDIRECTED_REQUEST),
        (b"GET / HTTP/1.1", (b"Host: \xff",), HTTPStatus.MISDIRECTED_REQUEST),
    ],
)
def test_refuses_malformed_requests(
    page: GuardedServer, request_line: bytes, headers: tuple[bytes, ...], status: HTTPStatus
) -> None:
    with socket.create_connection(("127.0.0.1", page.get_port()), 10.0) as connection:
        connection.sendall(b"\r\n".join((request_line, *headers, b"", b"")))
        assert int(connection.recv(4096).split()[1]) == status


def test_secrets_differ(page: GuardedServer) -> None:
    other = open_server("127.0.0.1", 0)
    try:
        assert urlsplit(other.address).path != urlsplit(page.address).path
        assert len(urlsplit(other.address).path) > 20
    finally:
        close_server(other)


def test_a_viser_that_does_not_ask_the_guard_is_refused() -> None:
    with pytest.raises(to.TrajoptError, match="cannot be guarded"), _asking(None):  # type: ignore[arg-type]
        pass
    assert issubclass(GuardedServer, ViserServer)
