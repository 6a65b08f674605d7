"""A planning server: robots, sessions with scenes and a pool of workers, behind HTTP and rosbridge.

`Service` is the core and independent of protocols; the faces translate network messages into calls of `ask`.
"""

from trajopt.server.limits import Limits as Limits
from trajopt.server.operation import Answer as Answer
from trajopt.server.operation import Lane as Lane
from trajopt.server.operation import Operation as Operation
from trajopt.server.refusals import Refusal as Refusal
from trajopt.server.refusals import Why as Why
from trajopt.server.requests import Cancellation as Cancellation
from trajopt.server.requests import Reply as Reply
from trajopt.server.service import Service as Service
from trajopt.server.session import Session as Session
from trajopt.server.state import SessionState as SessionState
from trajopt.server.watch import Watch as Watch
