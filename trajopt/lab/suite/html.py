"""Common parts of self-contained HTML pages: document, tables, words for an outcome."""

from base64 import b64encode
from collections.abc import Sequence
from html import escape

from trajopt.simulation.rendering import HEIGHT, TYPE, WIDTH
from trajopt.verify import Check, CheckKind

STYLE = """
:root { color-scheme: light dark; --line: #8884; --good: #1a7f37; --bad: #cf222e; --soft: #8881; }
body { font: 15px/1.45 system-ui, sans-serif; max-width: 80rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin-bottom: .2rem; } h2 { font-size: 1.15rem; margin: 2rem 0 .5rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; width: 100%; }
th, td { padding: .2rem .6rem; border-top: 1px solid var(--line); vertical-align: top; text-align: left; }
th.n, td.n { text-align: right; white-space: nowrap; }
details { border: 1px solid var(--line); border-radius: 6px; margin: .4rem 0; padding: 0 .8rem; }
summary { cursor: pointer; padding: .45rem 0; }
.good { color: var(--good); } .bad { color: var(--bad); } .faint { opacity: .7; }
"""


def document(title: str, style: str, body: str) -> str:
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width"><title>{escape(title)}</title>'
        f"<style>{STYLE}{style}</style></head><body><h1>{escape(title)}</h1>{body}</body></html>\n"
    )


def table(
    head: Sequence[str], rows: Sequence[Sequence[str]], *, numbers: Sequence[str] = (), kind: str = ""
) -> str:
    """Return a table; `kind` is its class in a page's style."""
    sides = [" class=n" if name in numbers else "" for name in head]
    titles = "".join(f"<th{side}>{escape(name)}</th>" for name, side in zip(head, sides, strict=True))
    body = "".join(
        "<tr>" + "".join(f"<td{side}>{cell}</td>" for side, cell in zip(sides, row, strict=True)) + "</tr>"
        for row in rows
    )
    return (
        f'<div class="wide"><table class="{kind}"><thead><tr>{titles}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def bar(share: float, *, good: bool = True) -> str:
    """Return a bar of a share of a bound, in the colour of a violation unless it is good."""
    kind = "" if good else ' class="bad"'
    width = 100.0 * min(share, 1.0)
    return f'<div class="bar" title="{share:.0%}"><i{kind} style="width:{width:.0f}%"></i></div>'


def used_share(check: Check) -> str:
    """Return a bar of the used share of an upper bound; empty without one."""
    if check.value is None or not check.bound or check.kind in (CheckKind.CLEARANCE, CheckKind.AT_FAULT):
        return ""
    return bar(abs(check.value / check.bound), good=check.holds)


def image(picture: bytes | None, words: str = "") -> str:
    if picture is None:
        return ""
    data = b64encode(picture).decode()
    return (
        f'<img src="data:{TYPE};base64,{data}" width="{WIDTH}" height="{HEIGHT}" alt="{escape(words)}" '
        'loading="lazy">'
    )


def status_words(status: str) -> str:
    """Return the name of a status in words."""
    return status.replace("_", " ").lower()
