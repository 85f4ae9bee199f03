"""Puts into the site what does not lie in docs/: the pictures and pages of viz/, the changelog and its neighbours. A hook of mkdocs, see
mkdocs.yml.

Pages in docs/ link to these files as they lie in the repository, ``../viz/report.png``; in the site that is ``viz/report.png``. The
changelog and its neighbours link to ``docs/balancing.md``, the pages of viz/ to ``../docs/balancing.md``; in the site they stand beside and
below the pages of docs/. At the foot of every page stands which version it is of.
"""

import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parent.parent
TOP = ("CHANGELOG.md", "CODE_OF_CONDUCT.md", "CONTRIBUTING.md", "SECURITY.md")
BESIDE = ("](../viz/", "](../CHANGELOG.md", "](../urdf/")
# Who searches finds the guide first, then examples (whose pages say so themselves), then names, evidence, and what is for contributors.
BELOW_THE_GUIDE = {"reference/pp": 0.6, "reference/": 0.3, "accuracy": 0.4, "limits": 0.4, "glossary": 0.3, "mistakes": 0.3}
BELOW_THE_GUIDE |= dict.fromkeys(("kong2025", "zhang2007", "chen2002", "viz/"), 0.2)
BELOW_THE_GUIDE |= {name.partition(".")[0]: 0.1 for name in TOP}


def on_config(config: Any) -> Any:
    """Material shows the line for the copyright at the foot of each page."""
    (version,) = re.findall(r'^__version__ = "(.*)"$', (ROOT / "pinpress" / "__init__.py").read_text(encoding="utf-8"), re.MULTILINE)
    config.copyright = f"pinpress {version}"
    return config


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
    for beginning, boost in BELOW_THE_GUIDE.items():
        if page.file.src_uri.startswith(beginning):
            page.meta.setdefault("search", {"boost": boost})
    for link in BESIDE:
        markdown = markdown.replace(link, link.replace("../", "", 1))
    if page.file.src_uri in TOP or page.file.src_uri.startswith("viz/"):
        markdown = markdown.replace("](docs/", "](").replace("](../docs/", "](../")
    return markdown
