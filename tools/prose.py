"""Count markers of unnatural English, and fail if they exceed a limit per 1,000 words.

Docstrings, messages (other strings of at least four words in the code), texts (the English of
screens and pages) and documentation are counted separately. The limit is the highest count in the
documentation of other scientific Python projects.

    python -m tools.prose               the counts
    python -m tools.prose --list PATH   every marker below a path
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
KINDS = ("docstrings", "messages", "texts", "documentation")
#: Limit for the number of markers per 1,000 words.
LIMIT = 2.0
#: Pattern of each marker of unnatural English, by name.
MARKERS = {
    "software that tells or says": r"\b(?:tell|tells|told)\b(?! apart)|\b(?:says|said)\b",
    "where for if": (
        r"(?:^|[.;,:] )[Ww]here (?:there|it|they|a|the|no|nothing|none|one|many|several|each|that"
        r"|this|all)\b"
    ),
    "a for per": (
        r"\b(?:one|row|line|file|value|seconds?|minutes|slope|field|pair|page|class|column|cell"
        r"|paragraph|name|number)s? an? (?:participant|trial|task|file|row|line|language|test"
        r"|question|person|pair|column|day|surface|block|condition|record|study|run|mode|fit|class"
        r"|field|key|concept)\b"
    ),
    "but for except": r"\bbut (?:for|where|with|of)\b",
    "go on with": r"\b(?:go|goes|gone|going) on\b",
    "stand for be": r"\bstands?\b|\bstood\b",
    "anew": r"\banew\b|\bmade again\b",
    "of its own": r"\bof (?:its|their|his|one's|your|a laboratory's|the study's) own\b",
    "beside": r"\bbeside\b",
    "so many": r"\bso (?:many|much)\b",
    "whose": r"\bwhoever\b|\bwhose\b",
    "all that there is": r"\b(?:all|what|none|whatever|nothing) (?:that )?there (?:is|are)\b",
    "by itself": r"\bby (?:itself|themselves)\b",
    "likewise": r"\blikewise\b",
    "comes again": r"\b(?:come|comes|felt|asked|presented) again\b",
    "is no": r"\bis no (?!longer)\w+",
    "some for about": r"\bsome \d",
    "look at": r"\blook(?:s|ed) (?:at|for)\b",
    "leave away": r"\b(?:leave|left) away\b|\blets? .{1,20} pass\b",
    "how strong": r"\bhow (?:strong|far|well|finely|steep|sure)\b",
}
ANY = re.compile("|".join(f"(?:{pattern})" for pattern in MARKERS.values()))
MESSAGE_WORDS = 4


def tracked(*patterns: str) -> list[Path]:
    """Return the tracked files that match."""
    words = ["git", "ls-files", "--", *patterns]
    found = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [ROOT / name for name in found.splitlines() if not name.startswith("tests/")]


def of_code(path: Path) -> Iterator[tuple[str, int, str]]:
    """Yield the kind, line and text of each docstring and message."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    docstrings = set()
    for node in ast.walk(tree):
        owners = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
        if isinstance(node, owners) and (text := ast.get_docstring(node)):
            docstrings.add(id(node.body[0].value))  # type: ignore[attr-defined] # an expression
            yield "docstrings", node.body[0].lineno, text
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and id(node) not in docstrings:
            message = node.value
            if isinstance(message, str) and message.count(" ") >= MESSAGE_WORDS - 1:
                yield "messages", node.lineno, message


def texts() -> Iterator[tuple[Path, str, int, str]]:
    """Yield the file, kind, line and content of each text that is counted."""
    for path in tracked("*.py"):
        if path != Path(__file__).resolve():
            for kind, line, text in of_code(path):
                yield path, kind, line, text
    for path in tracked("*/en.toml", "*.html"):
        yield path, "texts", 1, re.sub(r"<[^>]*>|\{[%{#].*?[%}#]\}", " ", path.read_text("utf-8"))
    for path in tracked("*.md"):
        if "decisions" not in path.parts:
            prose = re.sub(r"```.*?```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
            yield path, "documentation", 1, prose


def main(arguments: list[str]) -> int:
    """Print the counts and, with ``--list``, each marker; return the exit status."""
    below = [str((ROOT / each).resolve()) for each in arguments if not each.startswith("-")]
    words: Counter[str] = Counter()
    markers: Counter[str] = Counter()
    for path, kind, line, text in texts():
        words[kind] += len(text.split())
        for found in ANY.finditer(text):
            markers[kind] += 1
            if "--list" in arguments and (not below or str(path).startswith(tuple(below))):
                place = line + text[: found.start()].count("\n")
                print(f"{path.relative_to(ROOT)}:{place}: {found[0].strip()}")
    worse = []
    for kind in KINDS:
        rate = 1000 * markers[kind] / words[kind]
        worse += [kind] if rate > LIMIT else []
        print(f"{kind:<14}{words[kind]:>7} words, {markers[kind]:>5} markers: {rate:.1f} per 1,000")
    if worse:
        print(
            f"More than {LIMIT:g} markers of unnatural English per 1,000 words in "
            f"{', '.join(worse)}: "
            "python -m tools.prose --list PATH shows where.",
            file=sys.stderr,
        )
    return 1 if worse else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
