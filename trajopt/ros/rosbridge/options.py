"""Options of the bridge: addresses, admission of clients, and the ROS distribution."""

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


class Distro(Enum):
    """ROS distributions that the bridge supports."""

    NOETIC = ("noetic", 1, Generation.ROS1)
    JAZZY = ("jazzy", 2, Generation.ROS2)

    def __init__(self, title: str, version: int, generation: Generation) -> None:
        self.title, self.version, self.generation = title, version, generation


@checked
@dataclass(frozen=True, kw_only=True)
class RosbridgeOptions(Value):
    """Addresses of the bridge, and admission of clients.

    The protocol has no token: every client that reaches the port can drive the robot
    (docs/from-compas-fab.md#access).

    Attributes:
        mesh_port: Port of the meshes over HTTP; 0 for any free port.
        origins: Admitted origins of web pages, such as "https://cell.example".
        token: If not empty, required in the address: `ws://HOST:PORT/?token=TOKEN`.
        names: Further host names by which clients may call the server.
        clouds: Topics of `sensor_msgs/PointCloud2` that become obstacles.
        calls: Most requests of one connection in progress at a time.
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
            host: Host name in the client's request; a foreign page can make any name resolve to this machine.
            origin: Origin of the web page, set by its browser, which must be in `origins`; empty if the
                client is not a browser.
        """
        called = _name_in(f"//{host}")
        if not called or (not self.open and called not in {*LOCAL_NAMES, self.host, *self.names}):
            return False
        return not origin or origin in self.origins

    def knows(self, path: str) -> bool:
        """Whether the path of a request contains the token, if one is required."""
        given = parse_qs(path.partition("?")[2]).get("token", [""])[0]
        sent = given.encode(errors="surrogateescape")  # bytes beyond ASCII arrive as lone surrogates
        return hmac.compare_digest(sent, self.token.encode()) or not self.token


def _name_in(address: str) -> str:
    try:
        return urlsplit(address).hostname or ""
    except ValueError:
        return ""
