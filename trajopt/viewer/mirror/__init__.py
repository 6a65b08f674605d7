"""The mirror: a robot that is driven elsewhere, shown as it is, with what is known around it.

`mirror_view` shows what is at an address: a session of `trajopt serve`, or a run that a `Publisher` tells of.
"""

from trajopt.viewer.mirror.page import MirrorView as MirrorView
from trajopt.viewer.mirror.page import mirror_view as mirror_view
from trajopt.viewer.mirror.publisher import Publisher as Publisher
