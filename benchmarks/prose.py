"""Count hard-to-read phrases per 1,000 words of docstrings, messages and pages.

python -m benchmarks.prose [--show] [--rooms] [PATH ...]

Without paths: docstrings, notes on constants and message strings of `trajopt/`, README.md, docs/*.md,
docs/decisions/*.md and benchmarks/README.md, outside code blocks. `--show` prints each phrase in its context,
`--rooms` adds a line for each folder.
"""

import ast
import re
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

ROOT = Path(__file__).parents[1]
PATTERNS = {
    "what, as a pronoun": r"\bwhat\b(?! (?:if|is the|are the)\b)",
    "say, tell, ask": r"\b(?:says?|said|tells?|told|asks?|asked)\b",
    "where, for a condition": (
        r"\bwhere (?:it|that|this|there|nothing|nobody|one|no|a|the|they|any|both|these|such)\b"
    ),
    "so many, much, long, far": r"\bso (?:many|much|long|far|often)\b",
    "is no, are no": r"(?<!there )\b(?:is|are|was|were) no\b(?! (?:longer|more than)\b)",
    "the same of, that of, as of": r"\b(?:the same of|that of|those of|as of)\b",
    "at once, anew, beside": r"\b(?:at once|anew|besides?)\b",
    "whoever, whatever, nobody": r"\b(?:whoever|whatever|nobody|whichever)\b",
    "any more": r"\b(?:any more|no more)\b(?! than)",
    "stands, by then, thereof": r"\b(?:stand(?:s|ing)? (?:in|where|there|as)|by then|there(?:by|in|of))\b",
}
"""Phrase -> its pattern in lower case; docs/decisions/english.md has better words."""
COMPILED = {name: re.compile(pattern) for name, pattern in PATTERNS.items()}
WORD = re.compile(r"[a-z]+(?:'[a-z]+)?")
CODE = re.compile(r"```.*?```|^(?: {4}|\t).*?$|`(?:[^`\n]|\n(?!\s*\n))*`", re.DOTALL | re.MULTILINE)
"""Blocks and spans of code; a span ends with its paragraph, so that a single backtick hides no text."""
SENTENCE = 3
"""Spaces in a string that count as a message."""


def texts_of_module(path: Path) -> Iterator[str]:
    """Yield docstrings, notes on constants, and formatted strings of several words."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        match node:
            case ast.JoinedStr(values=parts):
                text = "".join(str(part.value) if isinstance(part, ast.Constant) else "X" for part in parts)
                if text.count(" ") >= SENTENCE:
                    yield text
            case ast.Expr(value=ast.Constant(value=str(text))):
                yield text
            case _:
                pass


def texts(path: Path) -> Iterator[str]:
    """Yield the texts of a module or page, in lower case."""
    found = (
        texts_of_module(path) if path.suffix == ".py" else [CODE.sub("X", path.read_text(encoding="utf-8"))]
    )
    for text in found:
        yield " ".join(text.lower().split())


def files_of(names: Sequence[str]) -> list[Path]:
    """Return the modules and pages of files and folders; the default ones if none is named."""
    pages = [ROOT / "README.md", *ROOT.glob("docs/*.md"), *ROOT.glob("docs/decisions/*.md")]
    default = [ROOT / "trajopt", *pages, ROOT / "benchmarks" / "README.md"]
    found: list[Path] = []
    for path in map(Path, names) if names else default:
        found += sorted((*path.rglob("*.py"), *path.rglob("*.md"))) if path.is_dir() else [path]
    return found


def main(arguments: Sequence[str]) -> None:
    """Print the counts."""
    counted, words = Counter[str](), Counter[str]()
    rooms: Counter[str] = Counter()
    for path in files_of([item for item in arguments if not item.startswith("--")]):
        room = "/".join(path.resolve().relative_to(ROOT).parts[:2])
        for text in texts(path):
            words[room] += len(WORD.findall(text))
            for name, pattern in COMPILED.items():
                for hit in pattern.finditer(text):
                    counted[name] += 1
                    rooms[room] += 1
                    if "--show" in arguments:
                        print(f"{path}: ...{text[max(0, hit.start() - 50) : hit.end() + 40]}...")
    total = sum(words.values())
    for name in PATTERNS:
        print(f"{counted[name]:6d} {1000 * counted[name] / max(1, total):6.2f}  {name}")
    print(
        f"{sum(counted.values()):6d} {1000 * sum(counted.values()) / max(1, total):6.2f}  in {total:,} words"
    )
    if "--rooms" in arguments:
        for room in sorted(words):
            print(f"{words[room]:7,} words {1000 * rooms[room] / max(1, words[room]):6.1f}  {room}")


if __name__ == "__main__":
    main(sys.argv[1:])
