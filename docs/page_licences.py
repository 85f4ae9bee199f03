"""What pages hold of others, as pinpress/visual/templates/licences.json, with licences and their texts.

`python docs/make.py page_licences 4.1.1 3.0.0` finds the parts of plotly.js in these versions (plotly.min.js of the Python package names
its own in its first lines). They are in no list: modules are named by comments of dist/plotly.js, which the npm package has beside the
minified file; those of stackgl, which is bundled without names, are found by their lines. Needs npm. Parts of Meshcat's viewer that its own
list leaves out stand below.
"""

import json
import re
import subprocess
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from make import ROOT, write

from pinpress.visual.pages import meshcat_script

BUNDLES_OF_THEIR_OWN = ("maplibre-gl", "@plotly/mapbox-gl")  # what they require is in them
SPDX = {"zlib": "Zlib", "BOOST": "BSL-1.0", "(MIT OR Apache-2.0)": "MIT OR Apache-2.0"}
UNSTATED = {  # licences that package.json does not tell, by what the packages' readme or licence file says
    "@mapbox/jsonlint-lines-primitives": ("MIT", "Copyright (C) 2012 Zachary Carter"),
    "@plotly/mapbox-gl": ("BSD-3-Clause", ""),
}
NEUQUANT = """NeuQuant Neural-Net Quantization Algorithm

Copyright (c) 1994 Anthony Dekker

NEUQUANT Neural-Net quantization algorithm by Anthony Dekker, 1994. See "Kohonen neural networks for optimal colour quantization" in
"Network: Computation in Neural Systems" Vol. 5 (1994) pp 351-367 for a discussion of the algorithm.

Any party obtaining a copy of these files from the author, directly or indirectly, is granted, free of charge, a full and unrestricted
irrevocable, world-wide, paid up, royalty-free, nonexclusive right and license to deal in this software and documentation files (the
"Software"), including without limitation the rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of
the Software, and to permit persons who receive copies from any such party to do so, with the only requirement being that this copyright
notice remain intact."""
IN_MESHCAT = [  # as comments of viewer/dist/main.js name them, where the sources stand that main.min.js is made of
    {"name": "isarray", "version": "1.0.0", "licence": "MIT", "notice": "Copyright (c) 2013 Julian Gruber", "text": "MIT"},
    {"name": "three-wtm", "version": "1", "licence": "MIT", "notice": "Copyright (c) 2021 Kai Salmen", "text": "MIT"},
    {"name": "earcut", "version": "2.2.2", "licence": "ISC", "notice": "Copyright (c) 2016, Mapbox", "text": "ISC"},
    {"name": "gif.js", "version": "0.2.0", "licence": "MIT", "notice": "Copyright (c) 2013 Johan Nordberg", "text": "MIT"},
    {"name": "NeuQuant", "version": "1994", "licence": "LicenseRef-NeuQuant", "notice": "", "text": NEUQUANT},
    {"name": "tar-js", "version": "", "licence": "MIT", "notice": "Copyright (c) 2011 Jameson Little", "text": "MIT"},
    {
        "name": "download.js",
        "version": "3.0",
        "licence": "CC-BY-2.0",
        "notice": "",
        "text": "download.js v3.0, by dandavis; 2008-2014. [CCBY2] see http://danml.com/download.html for tests/usage\n"
        "Licence: https://creativecommons.org/licenses/by/2.0/legalcode",
    },
]
HOLDER = re.compile(r"(?i)[\s*#>-]*(copyright\b|©|\(c\) ?\d)")
NO_HOLDER = re.compile(r"(?i)copyright (notice|holder|owner|license|and permission)|\(c\) You must")
TITLES = (
    r"(the )?(mit|isc|bsd[- 0-9a-z]*|internet systems consortium) licen[cs]e *(\(mit\))?|licen[cs]e:? *|\(?mit\)?"
    r"|this software is released under the mit license:?|all rights reserved\.?"
)


@dataclass(frozen=True)
class Package:
    """A package of npm: its licence as SPDX has it, its lines of copyright, the text of its licence file and that without these lines."""

    name: str
    version: str
    licence: str
    notice: str
    whole: str

    @property
    def body(self) -> str:
        lines = [line for line in self.whole.splitlines() if line.strip() and not _holds(line)]
        return "\n".join(line.rstrip() for line in lines if not re.fullmatch(TITLES, line.strip(" #=-*").lower()))


def _holds(line: str) -> bool:
    return bool(HOLDER.match(line)) and not NO_HOLDER.search(line)


def package(folder: Path) -> Package:
    about = json.loads((folder / "package.json").read_text("utf-8"))
    licence = about.get("license") or about.get("licenses")
    while isinstance(licence, list | dict):
        licence = licence[0] if isinstance(licence, list) else licence["type"]
    files = [path for path in sorted(folder.iterdir()) if re.match(r"(?i)(un)?licen[cs]e|copying", path.name) and path.is_file()]
    whole = files[0].read_text("utf-8", "replace") if files else _in_readme(folder)
    author = about.get("author") or ""
    author = re.sub(r" *[<(].*", "", author["name"] if isinstance(author, dict) else author)
    notices = [line.strip(" *#>-") for line in whole.splitlines() if _holds(line)]
    licence, holder = UNSTATED.get(about["name"], (SPDX.get(licence, licence), f"by {author}" if author else ""))
    notice = "; ".join(dict.fromkeys(notices)) or holder
    return Package(about["name"], about["version"], licence, notice.replace("&copy;", "(c)"), whole)


def _in_readme(folder: Path) -> str:
    """The section of a package's readme that tells its licence, where no file does."""
    for path in folder.glob("[rR][eE][aA][dD][mM][eE]*"):
        if section := re.search(r"(?ims)^#*\s*licen[cs]e\b.*", path.read_text("utf-8", "replace")):
            return section[0] if "ermission" in section[0] else "\n".join(line for line in section[0].splitlines() if _holds(line))
    return ""


def install(folder: Path, names: Iterable[str]) -> Path:
    """Packages of npm without their scripts; the folder that they are in."""
    folder.mkdir(exist_ok=True)
    (folder / "package.json").write_text("{}")
    subprocess.run(["npm", "install", "--ignore-scripts", "--no-audit", "--no-fund", "--silent", *names], cwd=folder, check=True)
    return folder / "node_modules"


def parts_of_plotly(version: str, folder: Path) -> Iterator[Package]:
    modules = install(folder / "plotly", [f"plotly.js@{version}"])
    bundle = (modules / "plotly.js" / "dist" / "plotly.js").read_text("utf-8")
    named = re.findall(r"^ *// \S*?(node_modules/\S+)$", bundle, re.MULTILINE)
    found = {folder / "plotly" / _folder(path) for path in named}
    for own in BUNDLES_OF_THEIR_OWN:
        if (modules / own).exists():
            required = json.loads((modules / own / "package.json").read_text("utf-8"))["dependencies"]
            nested = modules / own / "node_modules"
            found |= {(nested if (nested / name).exists() else modules) / name for name in required if not name.startswith("@types/")}
    there = {path for path in found if (path / "package.json").exists()}
    # Node's own modules and what these need come from the tools that plotly.js is built with, in versions of theirs.
    lent = {str(path).rpartition("node_modules/")[2] for path in found - there}
    lender = install(folder / "lent", lent)
    stackgl = modules / "plotly.js" / "stackgl_modules"
    required = json.loads((stackgl / "package.json").read_text("utf-8"))["dependencies"]
    forks = {name for name, number in required.items() if "#" in number}  # by Plotly: of the registry are the originals
    wanted = [name if name in forks else f"{name}@{number}" for name, number in required.items() if name != "glslify"]
    others = install(folder / "stackgl", wanted)
    inside = set(_with_lines_in((stackgl / "index.js").read_text("utf-8"), others)) | {others / name for name in forks}
    yield from map(package, sorted(there | inside))
    for name in sorted(lent):
        made = package(lender / name)
        yield Package(made.name, "", made.licence, made.notice, made.whole)


def _folder(path: str) -> str:
    """The folder of the package that a file is in."""
    head, _, rest = path.rpartition("node_modules/")
    words = rest.split("/")
    return f"{head}node_modules/{'/'.join(words[: 2 if words[0].startswith('@') else 1])}"


def _with_lines_in(bundle: str, modules: Path) -> Iterator[Path]:
    """Packages of which a file stands in a bundle, by most of its lines."""
    whole = "".join(bundle.split())
    for path in modules.rglob("*.js"):
        if not path.is_file() or re.search(r"/(test|example|www|demo)", str(path.relative_to(modules))):
            continue
        lines = ["".join(line.split()) for line in path.read_text("utf-8", "replace").splitlines() if "require(" not in line]
        lines = [line for line in lines if len(line) >= 30 and not line.startswith(("//", "*", "/*", '"use'))]
        if sum(line in whole for line in lines) > 0.6 * len(lines):
            yield Path(_folder(str(path)))


def written(versions: dict[str, list[Package]]) -> dict[str, object]:
    """The list: texts that several packages share stand once, of the others each has its own."""

    def letters(text: str) -> str:
        return re.sub(r"[^a-z0-9]+", "", text.lower())

    every = [part for parts in versions.values() for part in parts]
    shared = Counter((part.licence, letters(part.body)) for part in every if part.body)
    texts = {"Apache-2.0": _apache()}
    for (licence, body), count in shared.most_common():
        if licence not in texts and (count > 3 or any(part.licence == licence and not part.body for part in every)):
            texts[licence] = next(part.body for part in every if letters(part.body) == body)
    parts: dict[tuple[str, str], dict[str, Any]] = {}
    for version, found in versions.items():
        for part in found:
            common = part.licence in texts and letters(part.body) in ("", letters(texts[part.licence]))
            notice, text = (part.notice, part.licence) if common else ("", part.whole.strip())
            entry = {"name": part.name, "version": part.version, "licence": part.licence, "notice": notice, "text": text}
            made = parts.setdefault((part.name, part.version), entry | {"in": []})
            if version not in made["in"]:
                made["in"].append(version)
    ordered = [parts[key] for key in sorted(parts, key=lambda key: (key[0].lstrip("@"), key[1]))]
    return {"texts": texts, "meshcat": IN_MESHCAT, "plotly": ordered}


def _apache() -> str:
    """The licence's text, which packages name but seldom hold: from Meshcat's list."""
    script = meshcat_script()
    listed = json.loads(script.with_name(f"{script.name}.THIRD_PARTY_LICENSES.json").read_text("utf-8"))
    (text,) = (each["licenseText"] for each in listed if each["license"] == "Apache-2.0")
    return str(text).partition("APPENDIX:")[0].strip()


def main(quick: bool = False, parts: Sequence[str] = ()) -> None:
    """Write the list for these versions of plotly.js; ``quick``: of none, which needs no npm."""
    versions = {}
    for version in parts:
        with tempfile.TemporaryDirectory() as temporary:
            versions[version] = list(parts_of_plotly(version, Path(temporary)))
    if parts or quick:
        path = ROOT / "pinpress" / "visual" / "templates" / "licences.json"
        write(path, json.dumps(written(versions), indent=1, ensure_ascii=False) + "\n")
