"""Plans that are kept: a problem, and what became of it, in one file that says all.

`result.save("x.trajopt")`, `plan.save(...)` and `problem.save(...)` write one; `read_bundle` reads it on a
machine that has never seen the robot, `replay` plans anew and says what differs.
"""

from trajopt.bundle.bundle import Bundle as Bundle
from trajopt.bundle.bundle import Holds as Holds
from trajopt.bundle.reading import read_bundle as read_bundle
from trajopt.bundle.replay import Replay as Replay
from trajopt.bundle.replay import replay as replay
from trajopt.bundle.writing import save as save
