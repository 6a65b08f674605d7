"""Read one mesh file in a child process, since some files crash assimp.

Run as a script: a request in JSON on standard input, the triangles as .npz on standard output.
"""

import io
import json
import os
import sys

import coal
import numpy as np

REFUSED = 3


def main() -> int:
    """Answer one request."""
    request = json.loads(sys.stdin.buffer.read())
    answer = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # of what libraries print, nothing is an answer
    try:
        model = coal.MeshLoader().load(request["file"], np.array(request["scale"], dtype=np.float64))
    except (ValueError, RuntimeError) as error:
        if "bad_alloc" in str(error):
            raise MemoryError from error
        answer.write(_reason(str(error)).encode())
        answer.flush()
        return REFUSED
    corners = [model.tri_indices(face) for face in range(int(model.num_tris))]
    faces = np.array([(c[0], c[1], c[2]) for c in corners], dtype=np.int32).reshape(-1, 3)
    written = io.BytesIO()
    np.savez(written, vertices=np.array(model.vertices(), dtype=np.float64).reshape(-1, 3), faces=faces)
    answer.write(written.getvalue())
    answer.flush()
    return 0


def _reason(message: str) -> str:
    lines = [line.strip() for line in message.rsplit("message:", maxsplit=1)[-1].splitlines()]
    told = [line for line in lines if line and not line.startswith(("Could not load", "Hint"))]
    return told[0] if told else message


if __name__ == "__main__":
    sys.exit(main())
