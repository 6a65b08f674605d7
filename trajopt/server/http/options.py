"""Where the server listens, and whom it lets in."""

from dataclasses import dataclass
from ipaddress import ip_address

from trajopt.values.arrays import Value, at_least
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked

SHORTEST_TOKEN = 16
"""Characters of a token at least: fewer are guessed."""
LOCAL_NAMES = ("localhost", "127.0.0.1", "[::1]")
"""What browsers and clients on this machine call it."""


def is_loopback(host: str) -> bool:
    """Say whether an address is reached from this machine only."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


@checked
@dataclass(frozen=True, kw_only=True)
class HttpOptions(Value):
    """Where the server listens, and whom it lets in.

    Attributes:
        host: Address to listen on.
        port: Port; 0 for any that is free.
        token: What clients must send as `Authorization: Bearer TOKEN`; nothing where it is empty, which only
            an address of this machine itself may do.
        names: Names, beside that of the host, by which clients may call the server.
        connections: At a time.
        head: A request's head must be there so long after the connection is made [s].
        transfer: A request's body must be there, and an answer be taken, in so long [s].
    """

    host: str = "127.0.0.1"
    port: int = 8080
    token: str = ""
    names: tuple[str, ...] = ()
    connections: int = 512
    head: float = 10.0
    transfer: float = 30.0

    def __post_init__(self) -> None:
        """Refuse what would let anybody in.

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
        """Names by which clients may call the server, in lower case; all where the token is what counts."""
        return frozenset(name.lower() for name in (*LOCAL_NAMES, self.host, *self.names))
