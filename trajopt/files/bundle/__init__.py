"""Bundles: a problem and its result in one file.

`result.save("x.trajopt")` writes one, `read_bundle` reads it, `replay` plans it again.
"""

from trajopt.files.bundle.bundle import Bundle as Bundle
from trajopt.files.bundle.bundle import Holds as Holds
from trajopt.files.bundle.bundle import read_bundle as read_bundle
from trajopt.files.bundle.bundle import read_result as read_result
from trajopt.files.bundle.bundle import save as save
from trajopt.files.bundle.replay import Replay as Replay
from trajopt.files.bundle.replay import replay as replay
