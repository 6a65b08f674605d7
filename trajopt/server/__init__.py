"""A planning server: robots, sessions with scenes and a pool of workers, behind HTTP and rosbridge.

`Service` is the core; the faces translate network messages into requests.
"""

from trajopt.server.job import Cancellation as Cancellation
from trajopt.server.job import Reply as Reply
from trajopt.server.limits import Limits as Limits
from trajopt.server.limits import RequestRefused as RequestRefused
from trajopt.server.limits import Why as Why
from trajopt.server.operation import Answer as Answer
from trajopt.server.operation import Lane as Lane
from trajopt.server.operation import Operation as Operation
from trajopt.server.operation import SessionState as SessionState
from trajopt.server.operation import Watch as Watch
from trajopt.server.service import Service as Service
from trajopt.server.session import ServiceSession as ServiceSession
