"""Expand a xacro file in a child process that may read its packages and nothing else.

Standard input: a request in JSON; standard output: the URDF or a reason. Expressions of xacro are Python, so
limits of the operating system bound their effects (`trajopt/values/bounded_child.py`), and an audit
hook (PEP 578) refuses all other events. Functions without such an event are removed.
"""

import ast
import json
import os
import resource
import sys
from importlib import import_module
from pathlib import Path
from typing import Any, cast

REFUSED = 3
"""Exit status if a file cannot be expanded; the output is then the reason."""
MANIFEST = "package.xml"
ALLOWED = frozenset(
    (
        *(
            "compile",
            "exec",
            "marshal.loads",
            "os.listdir",
            "os.scandir",
            "os.walk",
            "glob.glob",
            "glob.glob/2",
        ),
        *("builtins.id", "object.__getattr__", "sys._getframe", "sys._getframemodulename"),
    )
)
"""Audit events of an expansion, beyond reading files."""
READING = frozenset(
    ("stat", "lstat", "fstat", "scandir", "listdir", "readlink", "getcwd", "fspath", "open", "close", "read")
)
"""Functions of the operating system that an expansion uses."""
INNER = ("_", "gi_", "cr_", "ag_", "tb_")
"""Prefixes of attributes that lead out of an expression: special ones, and the frames that run it."""


def readable(path: object, folders: tuple[str, ...], searched: tuple[str, ...]) -> bool:
    if not isinstance(path, str | bytes | Path):
        return False
    real = Path(os.path.realpath(os.fsdecode(path)))
    if any(real.is_relative_to(folder) for folder in folders):
        return True
    roots = [Path(folder) for folder in searched if real.is_relative_to(folder)]
    above = [parent for parent in real.parents if any(parent.is_relative_to(root) for root in roots)]
    return any((parent / MANIFEST).is_file() for parent in above)


def inner_names(expression: str) -> list[str]:
    nodes = list(ast.walk(ast.parse(expression.strip(), mode="eval")))
    attributes = {node.attr for node in nodes if isinstance(node, ast.Attribute)}
    variables = {node.id for node in nodes if isinstance(node, ast.Name)}
    return sorted(
        {name for name in attributes if name.startswith(INNER)}
        | {name for name in variables if name.startswith("__")}
    )


def disarm() -> None:
    """Remove system functions that change anything; some of them raise no audit event."""
    system = sys.modules[os.name]
    effects = [name for name, value in vars(system).items() if callable(value) and name not in READING]
    for module in (os, system):
        for name in effects:
            vars(module).pop(name, None)
    for functions in (
        os.supports_dir_fd,
        os.supports_effective_ids,
        os.supports_fd,
        os.supports_follow_symlinks,
    ):
        functions.clear()


def guard(folders: tuple[str, ...], searched: tuple[str, ...]) -> None:
    """Refuse everything but reading these folders; irreversible."""
    writing = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open":
            path, _, flags = arguments
            if flags & writing or not readable(path, folders, searched):
                raise PermissionError(f"may not open {path!r}, outside of the packages of the description")
        elif event not in ALLOWED:
            raise PermissionError(f"may not use {event}: expressions only compute")

    resource.setrlimit(resource.RLIMIT_NPROC, (0, 0))
    disarm()
    sys.addaudithook(hook)


def confine(expander: Any) -> None:
    """Make xacro refuse expressions with names that lead out of it."""
    plain, substitutions = expander.safe_eval, cast("Any", import_module("xacro.substitution_args"))

    def check(expression: str) -> None:
        if hidden := inner_names(expression):
            raise expander.XacroException(f"use of invalid name(s): {', '.join(hidden)}")

    def careful(expression: str, *symbols: Any) -> Any:
        check(expression)
        return plain(expression, *symbols)

    def careful_extension(expression: str, _: dict[str, Any], symbols: Any) -> Any:
        check(expression)
        return eval(expression, {"__builtins__": {}}, symbols)

    expander.safe_eval, substitutions.eval = careful, careful_extension
    for name in ("type", "vars"):  # these find attributes by text
        cast("dict[str, Any]", expander._global_symbols["python"]).pop(name)


def expand(request: dict[str, Any]) -> str:
    """Return the URDF of a request; nothing else can be done in this process from then on."""
    # Before the guard, since nothing can be imported from then on.
    xacro, packages, *_ = (
        import_module(name) for name in ("xacro", "xacrodoc.packages", "yaml", "xml.dom.expatbuilder")
    )
    expander, finder = cast("Any", xacro), cast("Any", packages)
    confine(expander)
    finder.reset()
    finder.look_in(request["packages"])
    finder.walk_up_from(request["file"])
    finder.update_package_cache(request["named"])
    guard(tuple(request["folders"]), tuple(request["searched"]))
    return str(expander.process_file(request["file"], mappings=request["arguments"]).toxml())


def reason(error: BaseException) -> str:
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
