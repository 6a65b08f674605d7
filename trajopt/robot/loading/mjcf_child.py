"""Compile a MuJoCo file in a child process, since some take all memory or crash.

Standard input: a request in JSON; standard output: a line of JSON with the warnings, then the model (.mjb).
"""

import json
import os
import sys
from importlib import import_module
from typing import Any

REFUSED = 3
UNKNOWN_MEANS = "it takes more than 4 GB of memory, or has a size that is impossible"


def main() -> int:
    """Answer one request."""
    request = json.loads(sys.stdin.buffer.read())
    answer = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # of what libraries print, nothing is an answer
    os.environ["MUJOCO_GL"] = "disable"
    numpy: Any = import_module("numpy")
    mujoco: Any = import_module("mujoco")
    warnings: list[str] = []
    mujoco.set_mju_user_warning(warnings.append)  # which else go into a file
    try:
        model = mujoco.MjModel.from_xml_path(request["file"])
        compiled = numpy.empty(mujoco.mj_sizeModel(model), dtype=numpy.uint8)
        mujoco.mj_saveModel(model, None, compiled)
    except (ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())  # it comes in several lines
        answer.write((f"{UNKNOWN_MEANS}: {reason}" if "unknown exception" in reason else reason).encode())
        answer.flush()
        return REFUSED
    answer.write(json.dumps(warnings).encode() + b"\n")
    answer.write(compiled.tobytes())
    answer.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main())
