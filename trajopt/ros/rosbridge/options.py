"""Where the bridge listens, whom it lets in, and which ROS it answers as."""

from dataclasses import dataclass
from enum import Enum
from ipaddress import ip_address
from urllib.parse import urlsplit

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

    Clients of rosbridge send no token: whoever reaches the port drives the robot. So it listens on this
    machine only, unless another address is given, and lets in no page of a browser that is not of this one
    or named here.

    Attributes:
        host: Address to listen on.
        port: Port of rosbridge; 0 for any that is free.
        mesh_port: Port of the meshes over HTTP; 0 for any that is free.
        distro: Which ROS it answers as.
        origins: Addresses of pages, such as "https://cell.example", that browsers may bring in.
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
        """Say whether a client may come in.

        Args:
            host: What it calls the server: a page elsewhere can have that name lead here.
            origin: Where the page is from that a browser shows; empty of what is no browser.
        """
        called = urlsplit(f"//{host}").hostname or ""
        known = {*LOCAL_NAMES, self.host, *self.names}
        if not self.open and called not in known:
            return False
        if not origin or origin in self.origins:
            return True
        return (urlsplit(origin).hostname or "") in known
