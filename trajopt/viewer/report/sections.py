"""The sections of a report, in HTML. Every text is escaped: names come from foreign files."""

from collections.abc import Callable, Iterator, Sequence
from html import escape

import numpy as np

from trajopt.files.proof import MotionProof
from trajopt.lab.suite.html import bar, status_words, table, used_share
from trajopt.planning.seeds import SeedKind
from trajopt.planning.status import Certainty, Status
from trajopt.robot.joints import joint_unit
from trajopt.values.arrays import Floats, floats
from trajopt.values.documents.document import Node
from trajopt.values.printed import capital, in_length, in_short, in_unit, shown_in
from trajopt.verify import Certificate, Check, CheckKind, Evidence
from trajopt.viewer.palette import LINES, hexadecimal
from trajopt.viewer.report.measured import Binding, Chart, Measured, Peak, Subject

PAIRS = 12
ATTEMPTS = 40
WAYS = 8
STAGES = {
    "examine": "examining start and goal", "seed": "first guesses", "optimise": "optimising",
    "retime": "timing", "verify": "judging", "explain": "explaining",
}  # fmt: skip


def section(name: str, title: str, body: str) -> str:
    return f'<section id="{name}"><h2>{escape(title)}</h2>{body}</section>' if body else ""


def proven(certificate: Certificate) -> str:
    """List the checks with their values, bounds and evidence; then the nearest pairs."""
    head = ("", "what", "where", "worst", "bound", "used", "at", "known")
    rows = [_check(check) for check in certificate.checks]
    pairs = [
        (
            escape(pair.first),
            escape(pair.second),
            "not proven" if pair.proven is None else in_length(pair.proven),
            in_length(pair.measured),
            in_length(pair.required),
            _moment(pair.time),
        )
        for pair in certificate.pairs[:PAIRS]
    ]
    near = table(
        ("of", "from", "proven", "measured", "required", "at"),
        pairs,
        numbers=("proven", "measured", "required", "at"),
    )
    counted = f"{len(certificate.pairs)} came near" if len(certificate.pairs) > PAIRS else ""
    notes = "".join(f"<li>{escape(note)}</li>" for note in certificate.notes)
    return (
        f"<p>{escape(capital(certificate.verdict))}. The judge looks at the timed motion alone, and shares "
        f"no code with the planner.</p>{table(head, rows, numbers=('worst', 'bound', 'at'), kind='checks')}"
        + (f"<h3>Clearance by pair</h3>{near}<p class=faint>{counted}</p>" if pairs else "")
        + (f"<ul class=faint>{notes}</ul>" if notes else "")
    )


def for_another_checker(proof: MotionProof) -> str:
    """Return the answer of the checker of proofs, the statement in words, and its size."""
    found = proof.check()
    *statement, verdict = found.words.splitlines()
    mark = f'<b class="{"good" if found.proven else "bad"}">{escape(verdict)}</b>'
    return (
        f"<p>{mark} by the checker that needs no trajopt: {escape(str(proof.size))}.</p>"
        f"<pre>{escape(chr(10).join(statement))}</pre>"
    )


def _check(check: Check) -> tuple[str, ...]:
    mark = {"ok": '<span class="good">✓</span>', "FAIL": '<span class="bad">✗</span>'}.get(check.mark, "")
    sign = (
        "≥ "
        if check.kind in (CheckKind.CLEARANCE, CheckKind.AT_FAULT) and check.evidence is Evidence.PROVEN
        else ""
    )
    return (
        mark,
        escape(check.name),
        escape(check.subject),
        "" if check.value is None else sign + _unit(in_unit(check.value, check.unit)),
        "" if check.bound is None else _unit(in_unit(check.bound, check.unit)),
        used_share(check),
        "" if check.time is None else _moment(check.time),
        f'<span title="{escape(check.detail)}">{check.evidence.value}</span>',
    )


def _moment(time: float) -> str:
    return f'<button class="at" data-at="{time:.6g}" title="show this moment">{time:.3f} s</button>'


def binding(measured: Measured, end: float) -> str:
    """List the intervals of binding limits, and the extremes of each joint."""
    if measured.bindings:
        drawn = (
            "<p>Within 1% of a limit, or within the margin of a clearance: these constraints would have "
            f"to give for a shorter motion.</p>{strips(measured.bindings, end)}"
        )
    else:
        drawn = "<p>No limit binds at any time: the motion could be faster.</p>"
    head = ("joint", "from", "to", "velocity", "acceleration", "jerk", "torque")
    rows = [_peak(peak) for peak in measured.peaks]
    keep = [column for column in range(len(head)) if any(row[column] for row in rows)]
    head = tuple(head[column] for column in keep)
    kept = [tuple(row[column] for column in keep) for row in rows]
    return f"{drawn}<h3>The most that each joint does</h3>{table(head, kept, numbers=head[1:])}"


def _peak(peak: Peak) -> tuple[str, ...]:
    most = (
        "" if each is None else f"{_unit(each[0])}{bar(each[1], good=each[1] <= 1.0)}" for each in peak.most
    )
    return (escape(peak.joint), escape(peak.begin), escape(peak.end), *most)


def _unit(words: str) -> str:
    return escape(words).replace("^2", "²").replace("^3", "³")


def costs(subject: Subject) -> str:
    """List the price of each active constraint."""
    units = {"mm": "1 mm", "deg": "1°", "rad": "1 rad", "%": "1%"}
    rows = [
        (
            escape(price.what),
            escape(units.get(price.unit, price.unit)),
            "" if price.seconds is None else change_of_duration(price.seconds),
            "" if price.objective is None else f"{price.objective:.2g}",
        )
        for price in subject.prices
    ]
    if not rows:
        return ""
    head = ("if this gave way", "by", "the motion would be", "cost of the path falls by")
    said = (
        "<p>What the motion pays for each constraint that holds it, computed by letting it give way a little "
        "and planning again. Prices are for small changes: they do not add up.</p>"
    )
    return said + table(head, rows, numbers=head[1:])


def in_the_way(subject: Subject) -> str:
    """List the obstacles, the nearest free configuration, and remedies."""
    told, parts = subject.explanation, list[str]()
    blocks = [block["words"].text() for block in told["blocks"].elements()]
    if blocks:
        more = f"<li class=faint>and {len(blocks) - WAYS} more</li>" if len(blocks) > WAYS else ""
        parts.append(f"<ul>{_items(blocks[:WAYS])}{more}</ul>")
    conflict = [each.text() for each in told["conflict"].elements()]
    if conflict:
        parts.append(f"<p>These cannot hold together; any one fewer can:</p><ul>{_items(conflict)}</ul>")
    parts.append(_nearest(subject))
    remedies = [each["words"].text() for each in told["remedies"].elements()]
    if remedies:
        parts.append(f"<h3>Each of these makes it solvable</h3><ul>{_items(remedies)}</ul>")
    details = [each.text() for each in told["details"].elements()]
    parts += [f"<p>{escape(each)}</p>" for each in details]
    return "".join(parts)


def _nearest(subject: Subject) -> str:
    free = subject.nearest_free
    if free is None:
        return ""
    model, names = subject.problem.scene.robot.model, subject.problem.reduced.joint_names
    near = subject.explanation["nearest_free"]
    moves = floats(near["moved"].place, near["moved"].numbers(), (len(names),))
    rows = list[tuple[str, ...]]()
    for name, position, moved in zip(names, free.tolist(), moves.tolist(), strict=True):
        unit, size = shown_in(joint_unit(model, name))
        said = f"{size * moved:+.2f} {unit}" if abs(moved) > 1e-9 else ""
        rows.append((escape(name), f"{size * position:.2f} {unit}", said))
    gap = "" if near["clearance"].missing else f", {in_length(near['clearance'].number())} clear"
    head = ("joint", "position", "moved by")
    return f"<h3>The nearest configuration that is free{gap}</h3>{table(head, rows, numbers=head[1:])}"


def tried(answer: Node) -> str:
    """List the attempts with outcome and cost."""
    tries = answer["tries"].elements()
    rows = [_try(each) for each in tries[:ATTEMPTS]]
    head = ("", "first guess", "how it ended", "steps", "particulars")
    method, because = answer["method"]["name"].text(""), answer["method"]["because"].text("")
    parts = (
        [f"<p>Planned by {escape(method)}{': ' + escape(because) if because else ''}.</p>"] if method else []
    )
    if rows:
        parts.append(table(head, rows, numbers=("", "steps")))
    if len(tries) > ATTEMPTS:
        parts.append(f"<p class=faint>and {len(tries) - ATTEMPTS} more</p>")
    return "".join((*parts, *_spent(answer)))


def _try(each: Node) -> tuple[str, ...]:
    kind, status = each["kind"].text(), each["status"].text()
    seed = SeedKind[kind].value if kind in SeedKind.__members__ else kind
    goal = each["goal_name"].text("")
    good = "good" if status == Status.SOLVED.name else "bad"
    return (
        f"{each['number'].number():g}",
        escape(seed + (f", for {goal}" if goal else "")),
        f'<span class="{good}">{escape(status_words(status))}</span>',
        f"{each['iterations'].number():g}",
        escape(each["message"].text("")),
    )


def _spent(answer: Node) -> Iterator[str]:
    seconds = {name: node.number() for name, node in answer["cpu_seconds"].members().items()}
    total = seconds.pop("total", sum(seconds.values()))
    if total > 0.0:
        rows = [
            (escape(STAGES.get(name, name)), f"{1000.0 * spent:.1f} ms", bar(spent / total))
            for name, spent in seconds.items()
        ]
        yield table(
            ("stage", "CPU", ""),
            [*rows, ("<b>all</b>", f"<b>{1000 * total:.1f} ms</b>", "")],
            numbers=("CPU",),
        )


def request(subject: Subject) -> str:
    return f"<pre>{escape(str(subject.problem))}</pre>"


def about(subject: Subject) -> str:
    by = ", ".join(f"{escape(name)} {escape(of)}" for name, of in subject.versions.items())
    return f"<p class=faint>Planned or kept {escape(subject.made)}, by {by}.</p>"


def meaning(status: str) -> str:
    return Status[status].value if status in Status.__members__ else ""


def certain(subject: Subject) -> str:
    told = subject.explanation
    known, grounds = told["certainty"].text(""), told["grounds"].text("")
    if known not in Certainty.__members__:
        return ""
    said = "This is proven" if known == Certainty.PROVEN.name else "This is evidence, and no proof"
    return f"{said}: {grounds}." if grounds else f"{said}."


def _items(words: Sequence[str]) -> str:
    return "".join(f"<li>{escape(each)}</li>" for each in words)


def change_of_duration(saved: float) -> str:
    milliseconds = float(f"{1000.0 * abs(saved):.2g}")
    return f"{milliseconds:g} ms {'longer' if saved < 0.0 else 'shorter'}"


WIDTH, HEIGHT = 960, 190
"""Of a plot, in its own units; it is drawn as wide as the page."""
LEFT, RIGHT, TOP, BOTTOM = 46, 8, 8, 24
"""Around the curves."""
STRIP = 20
NAMES = 260
LONGEST = 40
DASHES = ("", "6 3", "2 3", "8 3 2 3")
"""Of curves whose colours are used already."""
TICKS = 5
Place = Callable[[float], float]


def plot(chart: Chart) -> str:
    """Return a plot and its legend, in HTML."""
    lower, upper = _range(chart)
    end = float(chart.times[-1])
    left, right = LEFT, WIDTH - RIGHT

    def x(time: float) -> float:
        return left + (right - left) * time / end

    def y(value: float) -> float:
        return TOP + (HEIGHT - TOP - BOTTOM) * (upper - value) / (upper - lower)

    grid = [
        f'<line class="grid" x1="{left}" x2="{right}" y1="{y(tick):.1f}" y2="{y(tick):.1f}"/>'
        f'<text class="tick" x="{left - 6}" y="{y(tick) + 4:.1f}" text-anchor="end">{tick:g}</text>'
        for tick in ticks(lower, upper)
    ]
    limits = [
        f'<line class="limit {"soft" if name == "margin" else ""}" x1="{left}" x2="{right}" '
        f'y1="{y(value):.1f}" y2="{y(value):.1f}"><title>{escape(name)} {value:g} {escape(chart.unit)}'
        f'</title></line><text class="limit-name" x="{right - 4}" y="{y(value) - 4:.1f}" text-anchor="end">'
        f"{escape(name)}</text>"
        for value, name in chart.limits
        if lower <= value <= upper
    ]
    curves = [
        f'<path class="curve" style="{_stroke(number)}" d="{_path(chart.times, line.values, x, y, upper)}"/>'
        for number, line in enumerate(chart.lines)
    ]
    legend = "".join(
        f'<li><svg viewBox="0 0 22 8" aria-hidden="true"><path class="curve" style="{_stroke(number)}" '
        f'd="M1 4H21"/></svg><span>{escape(line.name)}</span> <b></b></li>'
        for number, line in enumerate(chart.lines)
    )
    return (
        f'<figure class="chart"><figcaption>{escape(chart.title)} '
        f'<span class="faint">[{escape(chart.unit)}]</span></figcaption>'
        f'<svg class="plot" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(chart.title)}" '
        f'data-left="{left}" data-right="{right}" data-end="{end:.9g}" data-top="{y(upper):g}" '
        f'data-bottom="{y(lower):g}" data-upper="{upper:.9g}" data-lower="{lower:.9g}">'
        f"{''.join(grid)}{_axis(end, x)}{''.join(limits)}{''.join(curves)}{_cursor(HEIGHT - BOTTOM)}</svg>"
        f'<ul class="legend">{legend}</ul></figure>'
    )


def strips(bindings: Sequence[Binding], end: float) -> str:
    """Return an SVG of strips, one for each limit: when it binds, from 0 to `end` [s]."""
    height = TOP + STRIP * len(bindings) + BOTTOM
    left, right = NAMES, WIDTH - RIGHT

    def x(time: float) -> float:
        return left + (right - left) * time / end

    rows: list[str] = []
    for number, binding in enumerate(bindings):
        top = TOP + STRIP * number
        rows.append(
            f'<text class="name" x="{left - 8}" y="{top + 14}" text-anchor="end">'
            f"{escape(in_short(binding.name, LONGEST))}</text>"
            f'<rect class="track" x="{left}" y="{top + 4}" width="{right - left}" height="{STRIP - 8}"/>'
        )
        rows += [
            f'<rect class="bound" x="{x(begin):.1f}" y="{top + 4}" '
            f'width="{max(x(stop) - x(begin), 2.0):.1f}" height="{STRIP - 8}">'
            f"<title>{begin:.3f} to {stop:.3f} s</title></rect>"
            for begin, stop in binding.spans
        ]
    return (
        f'<svg class="plot" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="When limits bind" '
        f'data-left="{left}" data-right="{right}" data-end="{end:.9g}">'
        f"{''.join(rows)}{_axis(end, x, height)}{_cursor(height - BOTTOM)}</svg>"
    )


def ticks(lower: float, upper: float) -> list[float]:
    rough = (upper - lower) / TICKS
    size = 10.0 ** np.floor(np.log10(rough))
    step = float(size * next(round_ for round_ in (1.0, 2.0, 5.0, 10.0) if round_ * size >= rough))
    first, last = int(np.ceil(lower / step - 1e-9)), int(np.floor(upper / step + 1e-9))
    return [round(number * step, 12) for number in range(first, last + 1)]


def _range(chart: Chart) -> tuple[float, float]:
    values = np.concatenate([line.values for line in chart.lines])
    values = values[np.isfinite(values)]
    if chart.top is not None:
        values = np.append(np.minimum(values, chart.top), chart.top)
    limits = [value for value, _ in chart.limits if chart.top is None or value <= chart.top]
    lowest = min([*limits, *([float(values.min())] if len(values) else [0.0])])
    highest = max([*limits, *([float(values.max())] if len(values) else [1.0])])
    if chart.unit == "m/s":
        lowest = 0.0
    room = 0.06 * max(highest - lowest, 1e-6 * max(abs(highest), 1.0))
    bottom = lowest if chart.unit == "m/s" else lowest - room
    return bottom, (highest if chart.top is not None else highest + room)


def _path(times: Floats, values: Floats, x: Place, y: Place, upper: float) -> str:
    words: list[str] = []
    pen = "M"
    for time, value in zip(times.tolist(), values.tolist(), strict=True):
        if not np.isfinite(value) or value > upper:
            pen = "M"
            continue
        words.append(f"{pen}{x(time):.1f} {y(value):.1f}")
        pen = "L"
    return "".join(words)


def _stroke(number: int) -> str:
    colour = hexadecimal(LINES[number % len(LINES)])
    dashes = DASHES[number // len(LINES) % len(DASHES)]
    return f"stroke:{colour}" + (f";stroke-dasharray:{dashes}" if dashes else "")


def _axis(end: float, x: Place, height: int = HEIGHT) -> str:
    marks = "".join(
        f'<text class="tick" x="{x(tick):.1f}" y="{height - 6}" text-anchor="middle">{tick:g}</text>'
        for tick in ticks(0.0, end)
        if tick < 0.96 * end
    )
    return f'{marks}<text class="tick" x="{x(end):.1f}" y="{height - 6}" text-anchor="end">{end:.3g} s</text>'


def _cursor(bottom: int) -> str:
    return f'<line class="cursor" x1="0" x2="0" y1="{TOP}" y2="{bottom}" visibility="hidden"/>'
