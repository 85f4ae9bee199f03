"""Puts into the site what does not lie in docs/: the pictures and pages of viz/, the changelog and its neighbours. A hook of mkdocs, see
mkdocs.yml.

Pages in docs/ link to these files as they lie in the repository, ``../viz/report.png``; in the site that is ``viz/report.png``. The
changelog and its neighbours link to ``docs/balancing.md``, the pages of viz/ to ``../docs/balancing.md``; in the site they stand beside and
below the pages of docs/.
"""

from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parent.parent
TOP = ("CHANGELOG.md", "CODE_OF_CONDUCT.md", "CONTRIBUTING.md", "SECURITY.md")
BESIDE = ("](../viz/", "](../CHANGELOG.md", "](../urdf/")


def on_files(files: Files, config: Any) -> Files:
    there = [
        *ROOT.glob("viz/*.png"),
        *ROOT.glob("viz/*.md"),
        *ROOT.glob("viz/*.csv"),
        *ROOT.glob("urdf/*.urdf"),
        *(ROOT / name for name in TOP),
    ]
    for path in there:
        files.append(File.generated(config, path.relative_to(ROOT).as_posix(), abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    for link in BESIDE:
        markdown = markdown.replace(link, link.replace("../", "", 1))
    if page.file.src_uri in TOP or page.file.src_uri.startswith("viz/"):
        markdown = markdown.replace("](docs/", "](").replace("](../docs/", "](../")
    return markdown
