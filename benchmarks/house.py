"""Facts about the sources, written into docs/architecture.md: layers, numbers and the picture of the flow.

python -m benchmarks.house
"""

import ast
import io
import sys
import tokenize
from collections.abc import Callable, Iterable
from pathlib import Path
from statistics import mean, median
from types import FrameType

import trajopt as to
from benchmarks.flow import PICTURE, picture
from benchmarks.page import table, write_section
from tests.architecture.import_graph import PACKAGE, ROOT, circles, file_graph, modules
from tests.architecture.test_layers import ORDER
from tests.architecture.test_public_names import public_names
from trajopt.planning.seeds import straight_line

PAGE = ROOT / "docs" / "architecture.md"
NOT_CODE = {
    *(tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT),
    *(tokenize.ENCODING, tokenize.ENDMARKER),
}
CHECKED = "checked.<locals>.call"
"""Wrapper that checks the arguments of a function; it is not counted as a step."""
CORE = ("sqp.py", "descend")
"""File and name of the function that calls the native core for the steps of the SQP."""


def layers() -> str:
    """Return the layers of the package as a table."""
    rows = [(str(number), " ".join(f"`{room}`" for room in rooms)) for number, rooms in enumerate(ORDER)]
    return table(("layer", "rooms"), rows[::-1])


def code_lines(text: str) -> int:
    """Count the lines that are neither blank nor comment nor docstring."""
    tree = ast.parse(text)
    prose = {
        line
        for node in ast.walk(tree)
        if isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
        for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)
    }
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    lines = {
        line
        for token in tokens
        if token.type not in NOT_CODE
        for line in range(token.start[0], token.end[0] + 1)
    }
    return len(lines - prose)


def files_naming(words: set[str], trees: Iterable[ast.Module]) -> int:
    """Count the files whose code names one of the words."""

    def named(tree: ast.Module) -> set[str]:
        names: set[str] = set()
        for node in ast.walk(tree):
            match node:
                case ast.Name(id=name) | ast.Attribute(attr=name) | ast.alias(name=name):
                    names.add(name)
                case ast.ClassDef(name=name) | ast.FunctionDef(name=name):
                    names.add(name)
                case _:
                    pass
        return names

    return sum(bool(words & named(tree)) for tree in trees)


def files_of_requirements() -> dict[str, int]:
    """Kind of requirement -> the files of the library that name its class."""
    from trajopt.problem.requirements import Requirement

    trees = [ast.parse(path.read_text()) for path in modules().values()]
    return {kind.__name__: files_naming({kind.__name__}, trees) for kind in Requirement.__subclasses__()}


def calls_to_the_core(planning: Callable[[to.Problem], object]) -> list[str]:
    """Return the functions of trajopt that lead from a call to the core of a descent, outermost first."""
    chain: list[str] = []

    def watch(frame: FrameType, event: str, argument: object) -> None:
        del argument
        code = frame.f_code
        if event != "call" or chain or (Path(code.co_filename).name, code.co_name) != CORE:
            return
        at: FrameType | None = frame
        while at is not None:
            inside = Path(at.f_code.co_filename).is_relative_to(PACKAGE)
            if inside and at.f_code.co_qualname != CHECKED:
                chain.append(at.f_code.co_qualname)
            at = at.f_back

    problem = teaching_problem()
    sys.setprofile(watch)
    try:
        planning(problem)
    finally:
        sys.setprofile(None)
    return chain[::-1]


def teaching_problem() -> to.Problem:
    """Return a problem of the teaching arm, whose planning calls every step."""
    arm = to.load("planar2")
    return to.Problem(
        scene=to.Scene(arm),
        start={"joint1": -1.0, "joint2": 0.3},
        goal=to.joint_positions({"joint1": 1.0, "joint2": 0.3}),
    )


def once(problem: to.Problem) -> to.Result:
    """Plan from the straight line."""
    goal = problem.reduced.start_positions.copy()
    goal[0] = 1.0
    return to.plan_once(problem, straight_line(problem.reduced.start_positions, goal, problem.knots))


def numbers() -> str:
    """Return the numbers of the house as a table."""
    texts = [path.read_text() for path in modules().values()]
    tests = [path.read_text() for path in (ROOT / "tests").rglob("*.py")]
    lengths = [text.count("\n") for text in texts]
    code, tested = (sum(map(code_lines, group)) for group in (texts, tests))
    native = [path.read_text() for path in PACKAGE.rglob("*.[ch]pp")]
    requirements = files_of_requirements()
    widest = max(requirements, key=lambda kind: requirements[kind])
    functions = sum(text.count("\ndef test_") for text in tests)
    rows = {
        "Python files / lines of `trajopt/`": f"{len(texts)} / {sum(lengths):,}",
        "of these lines, code": f"{code:,}",
        "mean / longest file": f"{mean(lengths):.0f} / {max(lengths)}",
        "C++ files / lines": f"{len(native)} / {sum(text.count(chr(10)) for text in native):,}",
        "import circles of files": str(len(circles(file_graph()))),
        "layers / rooms": f"{len(ORDER)} / {sum(map(len, ORDER))}",
        "functions from `plan` to the core of a descent": str(len(calls_to_the_core(to.plan)) + 1),
        "functions from `plan_once` to the core of a descent": str(len(calls_to_the_core(once)) + 1),
        "names in `import trajopt as to`": str(len(public_names())),
        "code lines of tests / of `trajopt/`": f"{tested / code:.2f} ({functions:,} test functions)",
        "files that name a built-in requirement, median / most": (
            f"{median(requirements.values()):g} / {requirements[widest]} (`{widest}`)"
        ),
    }
    return table(("measure", "value"), list(rows.items()))


def main() -> None:
    """Write the sections and the picture."""
    write_section(PAGE, "layers", layers())
    write_section(PAGE, "numbers", numbers())
    PICTURE.write_text(picture())
    print(f"written: {PAGE.relative_to(ROOT)}, {PICTURE.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
