"""A server of pages on a port of this machine, opened without announcements."""

from contextlib import redirect_stdout
from io import StringIO
from socket import create_server
from typing import TYPE_CHECKING

from trajopt.values.arrays import one_of
from trajopt.values.errors import MissingExtra, ProblemError, shown

if TYPE_CHECKING:
    from viser import ViserServer

LAST_PORT = 65535


def open_server(host: str, port: int) -> "ViserServer":
    """Serve an empty page.

    Args:
        host: Address to serve on.
        port: Port; the next free one if it is taken.

    Raises:
        MissingExtra: If viser is not installed.
        ProblemError: If nothing can be served on this host or port.
    """
    try:
        from viser import ViserServer
    except ImportError as error:
        raise MissingExtra("viser", "view") from error
    _check_address(one_of("host", host, str), port)
    with _unannounced():
        server = ViserServer(host, port, "trajopt", verbose=False)
    server.gui.configure_theme(show_logo=False, show_share_button=False, brand_color=(0x44, 0x77, 0xAA))
    return server


def close_server(server: "ViserServer") -> None:
    """Serve it no more."""
    with _unannounced():
        server.stop()


def address_of(server: "ViserServer") -> str:
    """Return the address of its page."""
    host = "localhost" if server.get_host() == "0.0.0.0" else server.get_host()
    return f"http://{host}:{server.get_port()}"


def _unannounced() -> redirect_stdout[StringIO]:
    """Keep viser's own announcements, which `verbose` does not stop, out of the caller's output."""
    return redirect_stdout(StringIO())


def _check_address(host: str, port: int) -> None:
    """Refuse addresses that cannot be served on: the server would wait for its own start.

    Raises:
        ProblemError: If the port is not a port number, or the address is not this machine's.
    """
    if type(port) is not int or not 0 <= port <= LAST_PORT:
        raise ProblemError(f"port must be a whole number from 0 to {LAST_PORT}, is {shown(port)}")
    try:
        create_server((host, 0)).close()
    except (OSError, UnicodeError) as error:
        raise ProblemError(f"view: nothing can be served on host {shown(host)}: {error}") from error
