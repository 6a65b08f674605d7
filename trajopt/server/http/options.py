"""Address and access control of the server."""

from dataclasses import dataclass
from ipaddress import ip_address

from trajopt.values.arrays import Value, at_least
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked

SHORTEST_TOKEN = 16
"""Characters of a token at least: fewer are guessed."""
LOCAL_NAMES = ("localhost", "127.0.0.1", "[::1]")
"""Names of this machine for local browsers and clients."""


def is_loopback(host: str) -> bool:
    """Return whether an address is reachable from this machine only."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


@checked
@dataclass(frozen=True, kw_only=True)
class HttpOptions(Value):
    """Address and access control of the server.

    Attributes:
        host: Address to listen on.
        port: Port; 0 for any free one.
        token: Required as `Authorization: Bearer TOKEN`; may be empty only on a loopback address.
        names: Accepted host names, in addition to the host.
        connections: Largest number of simultaneous connections.
        head: Time-out of a request's head after the connection [s].
        transfer: Time-out of a request's body, and of taking an answer [s].
    """

    host: str = "127.0.0.1"
    port: int = 8080
    token: str = ""
    names: tuple[str, ...] = ()
    connections: int = 512
    head: float = 10.0
    transfer: float = 30.0

    def __post_init__(self) -> None:
        """Refuse options that would admit every client.

        Raises:
            ProblemError: If other machines could connect without a token, or the token is short.
        """
        if not self.token and not is_loopback(self.host):
            raise ProblemError(
                f"on {self.host} other machines can connect: give a token, or listen on 127.0.0.1"
            )
        if self.token and len(self.token) < SHORTEST_TOKEN:
            raise ProblemError(f"a token has {SHORTEST_TOKEN} characters at least")
        at_least(self, 0, "port")
        at_least(self, 1, "connections")

    @property
    def hosts(self) -> frozenset[str]:
        """Accepted host names, in lower case; all if a token is required."""
        return frozenset(name.lower() for name in (*LOCAL_NAMES, self.host, *self.names))
