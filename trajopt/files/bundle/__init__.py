"""Plans that are kept: a problem, and what became of it, in one file that says all.

`result.save("x.trajopt")`, `plan.save(...)` and `problem.save(...)` write one; `read_bundle` reads it on a
machine that has never seen the robot, `replay` plans anew and says what differs.
"""

from trajopt.files.bundle.bundle import Bundle as Bundle
from trajopt.files.bundle.bundle import Holds as Holds
from trajopt.files.bundle.reading import read_bundle as read_bundle
from trajopt.files.bundle.replay import Replay as Replay
from trajopt.files.bundle.replay import replay as replay
from trajopt.files.bundle.writing import save as save
