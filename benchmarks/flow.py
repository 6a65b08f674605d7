"""The picture of docs/architecture.md: how a problem becomes a motion with a certificate, as an SVG.

python -m benchmarks.house writes it; tests/architecture/test_architecture_page.py holds it against the code.
"""

from dataclasses import dataclass
from html import escape
from pathlib import Path

PICTURE = Path(__file__).parents[1] / "docs" / "images" / "flow.svg"


@dataclass(frozen=True)
class Step:
    """A function between two values.

    Attributes:
        function: Where it is, with dots.
        call: How it is written in a program.
        value: The class of what it returns.
        symbol: What that is in mathematics or in words.
    """

    function: str
    call: str
    value: str
    symbol: str


FIRST = ("trajopt.Problem", "Problem", "scene, start, goal, constraints, costs")
STEPS = (
    Step(
        "trajopt.planning.seeds.straight_line",
        "straight_line(start, goal, knots)",
        "seed",
        "knots, shape (N, n)",
    ),
    Step(
        "trajopt.optimise.transcription.transcribe",
        "transcribe(problem, seed)",
        "KnotsNlp",
        "costs, bounds, derivatives",
    ),
    Step("trajopt.optimise.solvers.Sqp.solve", "Sqp().solve(nlp, seed)", "SolveResult", "optimal knots"),
    Step("trajopt.optimise.transcription.KnotsNlp.decode", "nlp.decode(x)", "Path", "q(s), no time yet"),
    Step(
        "trajopt.optimise.methods.retime_path",
        "retime_path(problem, path)",
        "Retimed",
        "q(t), fastest along q(s)",
    ),
    Step("trajopt.judge", "judge(problem, trajectory)", "Certificate", "every check, proven or not"),
)
ROOMS = {
    "trajopt.planning.seeds.straight_line": "planning",
    "trajopt.optimise.transcription.transcribe": "optimise, geometry",
    "trajopt.optimise.solvers.Sqp.solve": "optimise",
    "trajopt.optimise.transcription.KnotsNlp.decode": "optimise",
    "trajopt.optimise.methods.retime_path": "timing",
    "trajopt.judge": "verify",
}
"""The rooms that do the work of each step."""
OUTER = (("trajopt.plan_once", "plan_once(problem, seed)"), ("trajopt.plan", "plan(problem)"))

WIDTH, BOX_WIDTH, BOX_HEIGHT, PITCH, LEFT, TOP = 800, 250, 46, 88, 170, 20
LOOP, RIGHT = 30, 590
INK, SOFT, PAPER, LINE, ROOM = "#1b2733", "#5b6b7b", "#eef3f8", "#2f6f9f", "#a8540f"


def text(
    x: float,
    y: float,
    words: str,
    *,
    size: int = 14,
    colour: str = INK,
    style: str = "",
    anchor: str = "start",
) -> str:
    """Return a line of text."""
    return (
        f'<text x="{x:g}" y="{y:g}" font-size="{size}" fill="{colour}" text-anchor="{anchor}" {style}>'
        f"{escape(words)}</text>"
    )


def box(row: int, name: str, symbol: str) -> list[str]:
    """Return the box of a value."""
    y, middle = TOP + PITCH * row, LEFT + BOX_WIDTH / 2
    return [
        f'<rect x="{LEFT}" y="{y}" width="{BOX_WIDTH}" height="{BOX_HEIGHT}" rx="8" fill="{PAPER}" '
        f'stroke="{LINE}"/>',
        text(middle, y + 20, name, style='font-weight="600"', anchor="middle"),
        text(middle, y + 37, symbol, size=12, colour=SOFT, anchor="middle"),
    ]


def arrow(points: str) -> str:
    """Return a line that ends in an arrow."""
    return f'<path d="{points}" fill="none" stroke="{LINE}" stroke-width="1.6" marker-end="url(#head)"/>'


MONO = 'font-family="ui-monospace, Menlo, Consolas, monospace"'


def picture() -> str:
    """Return the picture."""
    parts = box(0, FIRST[1], FIRST[2])
    for row, step in enumerate(STEPS, start=1):
        middle, below = LEFT + BOX_WIDTH / 2, TOP + PITCH * row
        parts.append(arrow(f"M {middle:g} {below - PITCH + BOX_HEIGHT} V {below - 2}"))
        parts.append(text(middle + 14, below - 24, step.call, size=13, style=MONO))
        parts.append(text(middle + 14, below - 8, ROOMS[step.function], size=12, colour=ROOM))
        parts += box(row, step.value, step.symbol)
    first, last = TOP + PITCH, TOP + PITCH * len(STEPS) + BOX_HEIGHT / 2
    parts.append(
        f'<path d="M {RIGHT - 10} {first} H {RIGHT} V {last + 23:g} H {RIGHT - 10}" fill="none" '
        f'stroke="{SOFT}"/>'
    )
    parts.append(text(RIGHT + 10, (first + last) / 2, OUTER[0][1], size=13, style=MONO))
    parts.append(text(RIGHT + 10, (first + last) / 2 + 18, "one attempt", size=12, colour=SOFT))
    parts.append(arrow(f"M {LEFT - 2} {last:g} H {LOOP} V {first + 23} H {LEFT - 3}"))
    parts.append(text(LOOP, first - 22, OUTER[1][1], size=13, style=MONO))
    parts.append(text(LOOP, first - 4, "the next seed,", size=12, colour=SOFT))
    parts.append(text(LOOP, first + 12, "until one is verified", size=12, colour=SOFT))
    height = TOP + PITCH * len(STEPS) + BOX_HEIGHT + TOP
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" '
            f'height="{height}" font-family="system-ui, Helvetica, Arial, sans-serif">',
            '<defs><marker id="head" markerWidth="9" markerHeight="8" refX="8" refY="4" orient="auto">'
            f'<path d="M0,0 L9,4 L0,8 z" fill="{LINE}"/></marker></defs>',
            f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
            *parts,
            "</svg>",
            "",
        ]
    )
