"""Where the bridge listens, whom it lets in, and which ROS it answers as."""

import hmac
from dataclasses import dataclass
from enum import Enum
from ipaddress import ip_address
from urllib.parse import parse_qs, urlsplit

from trajopt.files.messages import Generation
from trajopt.values.arrays import Value, at_least
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked

LOCAL_NAMES = frozenset(("localhost", "127.0.0.1", "::1"))
"""What clients on this machine call it."""


class Distro(Enum):
    """The distributions of ROS that the bridge can answer as.

    Attributes:
        version: 1 or 2.
        generation: How its messages are written.
    """

    NOETIC = ("noetic", 1, Generation.ROS1)
    JAZZY = ("jazzy", 2, Generation.ROS2)

    def __init__(self, title: str, version: int, generation: Generation) -> None:
        """Keep its name and ways."""
        self.title, self.version, self.generation = title, version, generation


@checked
@dataclass(frozen=True, kw_only=True)
class RosbridgeOptions(Value):
    """Where the bridge listens, and whom it lets in.

    The protocol has no token: whoever reaches the port drives the robot. So it listens on this machine only,
    unless another address is given, admits no web page but those of `origins`, and may ask for a token in the
    address. The port of the meshes asks for none.

    Attributes:
        host: Address to listen on.
        port: Port of rosbridge; 0 for any that is free.
        mesh_port: Port of the meshes over HTTP; 0 for any that is free.
        distro: Which ROS it answers as.
        origins: Addresses of pages, such as "https://cell.example", that browsers may bring in.
        token: If not empty, a client connects by `ws://HOST:PORT/?token=TOKEN` only.
        names: Names, beside that of the host, by which clients may call the server.
        clouds: Topics of `sensor_msgs/PointCloud2` that become obstacles.
        connections: At a time.
        calls: Requests of one connection that are under way at a time.
        head: A connection must say what it wants in so long [s].
    """

    host: str = "127.0.0.1"
    port: int = 9090
    mesh_port: int = 9190
    distro: Distro = Distro.JAZZY
    origins: tuple[str, ...] = ()
    token: str = ""
    names: tuple[str, ...] = ()
    clouds: tuple[str, ...] = ()
    connections: int = 64
    calls: int = 64
    head: float = 10.0

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ShapeError: If a port is negative, or there may be no connection.
            ProblemError: If a topic is none.
        """
        strange = [topic for topic in self.clouds if not topic.startswith("/")]
        if strange:
            raise ProblemError(f"clouds: a topic begins with /, as /{strange[0]} does")
        at_least(self, 0, "port", "mesh_port")
        at_least(self, 1, "connections", "calls")

    @property
    def open(self) -> bool:
        """Whether other machines can connect."""
        try:
            return not ip_address(self.host).is_loopback
        except ValueError:
            return self.host not in LOCAL_NAMES

    def admits(self, host: str, origin: str) -> bool:
        """Whether a client may connect.

        Args:
            host: The name by which it calls the server: a foreign page can have any name lead here.
            origin: Origin of the web page, as its browser states it; empty if the client is not a browser. A
                page is admitted only if `origins` names it, whichever machine or port it is from.
        """
        called = _name_in(f"//{host}")
        if not called or (not self.open and called not in {*LOCAL_NAMES, self.host, *self.names}):
            return False
        return not origin or origin in self.origins

    def knows(self, path: str) -> bool:
        """Whether the path of a request holds the token, if one is needed."""
        given = parse_qs(path.partition("?")[2]).get("token", [""])[0]
        sent = given.encode(errors="surrogateescape")  # bytes beyond ASCII arrive as lone surrogates
        return hmac.compare_digest(sent, self.token.encode()) or not self.token


def _name_in(address: str) -> str:
    """Return the name of the host in an address; empty if it is not an address."""
    try:
        return urlsplit(address).hostname or ""
    except ValueError:
        return ""
