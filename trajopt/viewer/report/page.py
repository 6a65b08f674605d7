"""A report as one self-contained HTML page."""

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from pathlib import Path

from trajopt.files.bundle import Holds
from trajopt.values.documents.document import write_text
from trajopt.values.errors import RenderingUnavailable
from trajopt.values.errors.arguments import checked
from trajopt.viewer.report import sections
from trajopt.viewer.report.measured import Reported, Subject, measured, subject_of
from trajopt.viewer.report.scenery import HEIGHT, WIDTH, Scenery, Still, in_space, scenery, stills
from trajopt.viewer.report.sections import section

HERE = Path(__file__).parent
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval' blob:; "
    "style-src 'unsafe-inline'; img-src data: blob:; font-src data:; connect-src data: blob:; "
    "worker-src blob:; form-action 'none'; base-uri 'none'"
)
"""Content security policy: no access outside the page. The 3-D scene unpacks itself within it."""
WITHOUT_SCRIPTS = "<noscript><style>.space { display: none; } .stills { display: grid; }</style></noscript>"
"""Style without scripts: still pictures instead of the 3-D scene."""
KINDS = {Holds.PLAN: "plan", Holds.FAILURE: "failure", Holds.PROBLEM: "problem"}


def page(subject: Subject, shown: Scenery, space: str, pictures: Sequence[Still], remark: str) -> str:
    """Return the page.

    Args:
        subject: Its subject.
        shown: The shown robot.
        space: The 3-D page, in HTML; empty for none.
        pictures: Still pictures, for paper and for browsers without 3-D.
        remark: A sentence for the foot of the page.
    """
    name = subject.problem.name or "problem"
    parts = [
        _head(subject),
        _space(shown, space, pictures),
        _stills(pictures, alone=not space),
        *_parts(subject),
    ]
    foot = sections.about(subject) + (f"<p class=faint>{escape(remark)}</p>" if remark else "")
    style, script = ((HERE / f"page.{kind}").read_text(encoding="utf-8") for kind in ("css", "js"))
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><title>{escape(name)}</title>'
        f"<style>{style}</style>{WITHOUT_SCRIPTS}</head><body>{''.join(parts)}<footer>{foot}</footer>"
        f"<script>{script}</script></body></html>\n"
    )


def _parts(subject: Subject) -> list[str]:
    """Return the sections, the most important first."""
    parts: list[str] = []
    if not subject.verified:
        parts.append(section("blocked", "What stands in the way", sections.in_the_way(subject)))
    if subject.certificate is not None:
        title = "What was proven" if subject.verified else "What the judge found"
        parts.append(section("proven", title, sections.proven(subject.certificate)))
    if subject.trajectory is not None:
        seen = measured(subject.problem, subject.trajectory)
        parts.append(
            section("limits", "Where limits bind", sections.binding(seen, subject.trajectory.duration))
        )
        parts.append(section("prices", "What the constraints cost", sections.costs(subject)))
        parts.append(section("time", "Over time", sections.over_time(seen)))
    parts.append(section("tried", "What was tried", sections.tried(subject.answer)))
    parts.append(section("asked", "What was asked", sections.request(subject)))
    return parts


def _head(subject: Subject) -> str:
    problem = subject.problem
    kind = KINDS[subject.holds]
    facts = [("robot", problem.scene.robot.name), ("group", problem.group)]
    if subject.trajectory is not None:
        facts.append(("duration", f"{subject.trajectory.duration:.3f} s"))
    if subject.certificate is not None:
        told = subject.certificate.closest.removeprefix("clearance ")
        facts.append(("clearance", told))
    total = subject.answer["cpu_seconds"]["total"]
    if not total.missing:
        facts.append(("planning", f"{1000.0 * total.number():.0f} ms of CPU"))
    listed = "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>" for name, value in facts)
    return (
        f'<header><div class="over-title">trajopt report of a {kind}</div>'
        f"<h1>{escape(problem.name or 'problem')}</h1>"
        f'<p class="verdict">{_verdict(subject)}</p><dl>{listed}</dl></header>'
    )


def _verdict(subject: Subject) -> str:
    """Summarise the outcome in one sentence."""
    certificate = subject.certificate
    if subject.verified and certificate is not None:
        count = sum(check.required for check in certificate.checks)
        return f'<b class="good">✓ Proven.</b> All {count} checks of the judge hold.'
    if certificate is not None and subject.status in ("", "SOLVED"):
        return f'<b class="bad">✗ Not proven.</b> {escape(certificate.verdict)}.'
    if not subject.status:
        return "Nobody has planned it yet."
    reason = subject.answer["message"].text("").removeprefix(f"{subject.status}: ")
    words = sections.in_words(subject.status)
    known = sections.certain(subject)
    return (
        f'<b class="bad">✗ No plan: {escape(words)}.</b> {escape(reason or sections.meaning(subject.status))}'
        + (f'<br><span class="faint">{escape(known)}</span>' if known else "")
    )


def _space(shown: Scenery, space: str, pictures: Sequence[Still]) -> str:
    """Return the motion in 3-D, in a frame that can only draw, behind a still picture until it has drawn."""
    if not space:
        return ""
    held = escape(space, quote=True)
    poster = "".join(
        f'<img class="poster" src="{_source(still)}" alt="{escape(still.words)}">' for still in pictures[:1]
    )
    return (
        '<figure class="space screen waiting"><div class="view"><iframe title="The motion in 3-D" '
        f'sandbox="allow-scripts" srcdoc="{held}"></iframe>{poster}</div><figcaption>{escape(shown.words)} '
        '<span class="turn">Drag to turn, scroll to come nearer'
        f"{'; the bar below is time' if shown.motion is not None else ''}.</span></figcaption></figure>"
    )


def _stills(pictures: Sequence[Still], *, alone: bool) -> str:
    """Return still pictures: on paper, and on the screen without 3-D."""
    if not pictures:
        return ""
    kind = f"stills{' shown' if alone else ''}{' one' if len(pictures) == 1 else ''}"
    drawn = "".join(
        f'<figure><img src="{_source(each)}" width="{WIDTH}" height="{HEIGHT}" alt="{escape(each.words)}">'
        f"<figcaption>{escape(each.words)}</figcaption></figure>"
        for each in pictures
    )
    return f'<div class="{kind}">{drawn}</div>'


def _source(picture: Still) -> str:
    return f"data:image/jpeg;base64,{b64encode(picture.jpeg).decode()}"


@checked
def write_report(what: Reported, path: Path | str, *, moving: bool = True, pictures: bool = True) -> Path:
    """Write a report: one self-contained HTML page, for a browser or for printing.

    It shows the motion in 3-D, the proof, binding limits, curves over time, prices of the constraints and all
    attempts; for a failure the cause and the nearest free configuration. A motion of a bundle is judged
    again.

    Args:
        what: A result, a plan, an unplanned problem, or a bundle, which is drawn as by `trajopt view` after
            its meshes are unpacked (`read_bundle`).
        path: The file.
        moving: Whether to include the 3-D motion, which takes about a megabyte and the extra `view`.
        pictures: Whether to include still pictures, for paper. Without OpenGL they are omitted with a remark.

    Returns:
        The path.

    Raises:
        MissingExtra: If the 3-D motion is requested, and viser is not installed.
        FileFormatError: If the file cannot be written, or a bundle is invalid.
    """
    subject = subject_of(what)
    shown = scenery(subject)
    remark, drawn = "", ()
    if pictures:
        try:
            drawn = stills(subject, shown)
        except RenderingUnavailable as missing:
            remark = f"There are no still pictures: {missing}"
    write_text(path, page(subject, shown, in_space(subject, shown) if moving else "", drawn, remark))
    return Path(path)
