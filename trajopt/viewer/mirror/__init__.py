"""The mirror: a view of a robot that is driven elsewhere, with its known surroundings.

`mirror_view` shows a session of `trajopt serve`, or a run with a `Publisher`.
"""

from trajopt.viewer.mirror.page import MirrorView as MirrorView
from trajopt.viewer.mirror.page import mirror_view as mirror_view
from trajopt.viewer.mirror.publisher import Publisher as Publisher
