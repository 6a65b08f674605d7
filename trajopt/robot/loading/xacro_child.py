"""Expands one xacro file in a process of its own, which may read its packages and do nothing else.

Run as a script: a request in JSON on standard input, the URDF or a reason on standard output. Expressions of
xacro are Python, and xacro's own check of them can be evaded, so their effects are bounded from outside: by
limits of the operating system (`trajopt/values/documents/bounded_child.py`), and by an audit hook (PEP 578)
that refuses what expanding does not need.
"""

import json
import os
import resource
import sys
from importlib import import_module
from pathlib import Path
from sysconfig import get_path
from types import CodeType
from typing import Any, cast

REFUSED = 3
"""Exit status where a file cannot be expanded; the reason is the output then."""
MANIFEST = "package.xml"
ALLOWED = frozenset(
    (
        *("compile", "exec", "marshal.loads", "os.listdir", "os.scandir", "os.walk"),
        *("builtins.id", "object.__getattr__", "sys._getframe", "sys._getframemodulename"),
    )
)
"""Events of the audit hook that expanding raises, besides reading files."""


def readable(path: object, folders: tuple[str, ...], searched: tuple[str, ...]) -> bool:
    """Whether a file may be read: in one of the folders, or in a package below a searched one.

    Args:
        path: The file, as it is opened.
        folders: Folders whose files may all be read.
        searched: Folders in which only packages, which have a manifest, may be read.
    """
    if not isinstance(path, str | bytes | Path):
        return False
    real = Path(os.path.realpath(os.fsdecode(path)))
    if any(real.is_relative_to(folder) for folder in folders):
        return True
    roots = [Path(folder) for folder in searched if real.is_relative_to(folder)]
    above = [parent for parent in real.parents if any(parent.is_relative_to(root) for root in roots)]
    return any((parent / MANIFEST).is_file() for parent in above)


def names_in(code: CodeType) -> set[str]:
    """Return the names that code uses, with those of the functions inside it."""
    inner = [names_in(each) for each in code.co_consts if isinstance(each, CodeType)]
    return {*code.co_names, *code.co_varnames}.union(*inner)


def guard(folders: tuple[str, ...], searched: tuple[str, ...]) -> None:
    """Refuse from now on everything but reading these folders; it cannot be undone."""
    writing = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
    library = tuple(os.path.realpath(get_path(name)) for name in ("stdlib", "purelib", "platlib"))

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open":
            path, _, flags = arguments
            code = str(path).endswith((".py", ".pyc")) and readable(path, library, ())
            if flags & writing or not (code or readable(path, folders, searched)):
                raise PermissionError(f"may not open {path!r}, outside of the packages of the description")
        elif event not in ALLOWED and not (event == "import" and arguments[1] is None):
            # An import with a file name loads compiled code, which raises no events.
            raise PermissionError(f"may not use {event}: expressions only compute")

    resource.setrlimit(resource.RLIMIT_NPROC, (0, 0))
    sys.addaudithook(hook)


def expand(request: dict[str, Any]) -> str:
    """Return the URDF of a request: `file`, `arguments`, `packages`, `folders` and `searched`."""
    # Before the guard: compiled code can be imported until then only.
    xacro, packages, *_ = (import_module(name) for name in ("xacro", "xacrodoc.packages", "yaml", "pyexpat"))
    expander, finder = cast("Any", xacro), cast("Any", packages)
    plain = expander.safe_eval

    def careful(expression: str, *symbols: Any) -> Any:
        names = names_in(compile(expression.strip(), "<expression>", "eval"))
        hidden = sorted(name for name in names if name.startswith("_"))
        if hidden:
            raise expander.XacroException(f"use of invalid name(s): {', '.join(hidden)}")
        return plain(expression, *symbols)

    expander.safe_eval = careful
    finder.reset()
    finder.look_in(request["packages"])
    finder.walk_up_from(request["file"])
    guard(tuple(request["folders"]), tuple(request["searched"]))
    return str(expander.process_file(request["file"], mappings=request["arguments"]).toxml())


def reason(error: BaseException) -> str:
    """Return why a file cannot be expanded."""
    if isinstance(error, MemoryError) or isinstance(getattr(error, "exc", None), MemoryError):
        return "it takes too much memory"
    return f"{type(error).__name__}: {error}"


def main() -> int:
    """Answer one request."""
    request = json.loads(sys.stdin.buffer.read())
    answer, sys.stdout = sys.stdout.buffer, sys.stderr
    try:
        answer.write(expand(request).encode())
        return 0
    except BaseException as error:  # whatever expressions raise, the parent reports it
        answer.write(reason(error)[:2000].encode(errors="replace"))
        return REFUSED
    finally:
        answer.flush()


if __name__ == "__main__":
    sys.exit(main())
