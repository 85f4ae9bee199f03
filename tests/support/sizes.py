"""Sizes of the project: `python tests/support/sizes.py` prints lines by room, words of the documentation, and lines of the tests.

They say where the weight is, and judge nothing: what may be shorter is found by reading.
"""

import ast
import io
import tokenize
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def code_lines(text: str) -> int:
    """Lines of a module that are neither empty nor comments nor docstrings."""
    documented = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)]
    docstrings = [node.body[0] for node in documented if ast.get_docstring(node, clean=False) is not None]
    skipped = {line for node in docstrings for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)}
    blank = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER)
    tokens = (token for token in tokenize.generate_tokens(io.StringIO(text).readline) if token.type not in blank)
    return len({line for token in tokens for line in range(token.start[0], token.end[0] + 1)} - skipped)


def counted(files: Iterable[Path], top: Path) -> dict[str, tuple[int, int, int]]:
    """Folder below ``top`` -> modules, lines and lines of code."""
    modules, lines, code = Counter[str](), Counter[str](), Counter[str]()
    for path in files:
        text, parts = path.read_text(encoding="utf-8"), path.relative_to(top).parts
        folder = parts[0] if len(parts) > 1 else "."
        modules[folder] += 1
        lines[folder] += text.count("\n")
        code[folder] += code_lines(text)
    return {folder: (modules[folder], lines[folder], code[folder]) for folder in sorted(modules)}


def report() -> str:
    """All sizes, as text."""
    parts = []
    for name in ("pinpress", "tests", "viz", "docs"):
        sizes = counted((ROOT / name).rglob("*.py"), ROOT / name)
        parts.append(f"{name:28}{'modules':>9}{'lines':>9}{'code':>9}")
        total = tuple(sum(column) for column in zip(*sizes.values(), strict=True))
        rows = [*sizes.items(), ("together", total)] if len(sizes) > 1 else list(sizes.items())
        parts += [f"  {folder:26}" + "".join(f"{size:9}" for size in row) for folder, row in rows]
    pages = [*(ROOT / "docs").rglob("*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]
    words = {path: len(path.read_text(encoding="utf-8").split()) for path in pages}
    parts.append(f"{len(pages)} pages, {sum(words.values())} words; the longest:")
    parts += [f"  {path.relative_to(ROOT).as_posix():40}{words[path]:9}" for path in sorted(words, key=words.__getitem__)[:-11:-1]]
    return "\n".join(parts)


if __name__ == "__main__":
    print(report())
