"""Puts into the site what does not lie in docs/: the pictures and pages of viz/, and the changelog. A hook of mkdocs, see mkdocs.yml.

Pages in docs/ link to these files as they lie in the repository, ``../viz/report.png``; in the site that is ``viz/report.png``.
"""

from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parent.parent
BESIDE = ("](../viz/", "](../CHANGELOG.md", "](../urdf/")


def on_files(files: Files, config: Any) -> Files:
    there = [*ROOT.glob("viz/*.png"), *ROOT.glob("viz/*.md"), *ROOT.glob("viz/*.csv"), *ROOT.glob("urdf/*.urdf"), ROOT / "CHANGELOG.md"]
    for path in there:
        files.append(File.generated(config, path.relative_to(ROOT).as_posix(), abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    for link in BESIDE:
        markdown = markdown.replace(link, link.replace("../", "", 1))
    return markdown
