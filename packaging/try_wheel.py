"""Installs a wheel in a fresh environment where no compiler is found, and runs the README's first plan there.

python packaging/try_wheel.py WHEEL
"""

import os
import re
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

README = Path(__file__).parents[1] / "README.md"
WINDOWS = re.compile(r"^to\.(render|view)\(.*$", re.MULTILINE)
"""What needs a display or the viewer's packages, which are no matter of the wheel."""


def main(wheel: Path) -> None:
    """Install the wheel and plan with it."""
    code = re.search(r"```python\n(.*?)```", README.read_text(), re.DOTALL)
    assert code is not None, "the README begins with a plan"
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        python = str(Path(folder) / "bin" / "python")
        # Only the environment itself is on the path, and compilers that are named do not exist.
        alone = os.environ | {"PATH": str(Path(python).parent), "CC": "/nowhere/cc", "CXX": "/nowhere/c++"}
        alone.pop("PYTHONPATH", None)

        def run(*arguments: str) -> None:
            subprocess.run([python, *arguments], check=True, env=alone, cwd=folder)

        run("-m", "pip", "install", "--quiet", "--only-binary", ":all:", f"{wheel.resolve()}[robots]")
        run("-c", "from trajopt.native import native_cores; print(*native_cores())")
        run("-c", WINDOWS.sub("", code[1]))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
