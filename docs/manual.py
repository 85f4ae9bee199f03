"""The manual as one PDF: all pages of the site but the changelog, in the order of its menu, with contents and page numbers.

Chromium prints out/manual.pdf from the site in out/site, with `pip install -e '.[docs,video]'`, in some minutes. The changelog is left out:
in it readers look things up, on the site.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from make import OUT, ROOT, chromium

import pinpress as pp

LEFT_OUT = ("CHANGELOG.md",)
BELOW = ("examples.md",)  # whose links are chapters, which the menu does not have
# Pages are read from the built site and put one behind the other into the first one, whose style they have. Names of places begin with that
# of their page, so that links lead to places of the manual.
ASSEMBLE = """([chapters, title, pages]) => {
    const place = (page, name) => name ? `${page}--${name}` : page;
    const known = new Set(chapters.filter(each => each.html).map(each => each.page));
    const resolved = (page, target) => new URL(target, `https://manual/${page}`);
    const contents = chapters.map(({page, title, depth, html}) => html
        ? `<p class="entry" style="margin-left: ${depth}em"><a href="#${page}">${title}</a><i></i><span>${pages[page] ?? ""}</span></p>`
        : `<p class="part" style="margin-left: ${depth}em">${title}</p>`).join("");
    const bodies = chapters.filter(each => each.html).map(({page, html}) => {
        const article = new DOMParser().parseFromString(html, "text/html").querySelector("article");
        article.querySelectorAll(".headerlink, .md-content__button, .md-source-file, .md-tags").forEach(each => each.remove());
        article.querySelectorAll("[id]").forEach(each => { each.id = place(page, each.id); });
        article.querySelectorAll("[src]").forEach(each => {
            each.setAttribute("src", resolved(page, each.getAttribute("src")).pathname.slice(1));
        });
        article.querySelectorAll("a[href]").forEach(each => {
            const target = each.getAttribute("href");
            if (/^[a-z]+:/.test(target)) return;
            const {pathname, hash} = resolved(page, target);
            const other = decodeURI(pathname.slice(1));
            if (known.has(other)) each.setAttribute("href", "#" + place(other, decodeURI(hash.slice(1))));
            else each.removeAttribute("href");
        });
        return `<section id="${page}" class="chapter md-typeset">${article.innerHTML}</section>`;
    });
    const front = `<div class="md-typeset front"><h1>${title}</h1><div class="contents">${contents}</div></div>`;
    document.body.innerHTML = front + bodies.join("");
    document.body.removeAttribute("class");
}"""
# Links that lead to no place of the manual, and pictures that do not load
LOST = """async () => [
    ...[...document.querySelectorAll("a[href^='#']")].map(link => link.getAttribute("href"))
        .filter(target => !document.getElementById(decodeURIComponent(target.slice(1)))),
    ...await Promise.all([...document.images].map(image => image.decode().then(() => null, () => image.src))),
].filter(Boolean)"""
STYLE = """
html, body { font-size: 62.5%; background: white; }
body { display: block; }
.md-typeset { font-size: 1.3rem; line-height: 1.4; }
.chapter { break-before: page; }
.md-typeset h1 { font-size: 2.2rem; margin: 0 0 1.2rem; }
.md-typeset h2 { font-size: 1.7rem; margin: 1.6rem 0 0.6rem; } .md-typeset h3 { font-size: 1.4rem; }
h1, h2, h3, h4 { break-after: avoid; }
p, li, tr, img, .doc-heading { break-inside: avoid; }
.md-typeset pre > code, .md-typeset code { white-space: pre-wrap; overflow-wrap: anywhere; font-size: 0.98rem; line-height: 1.25; }
.md-typeset table:not([class]) { font-size: 1.05rem; display: table; width: 100%; }
.md-typeset table:not([class]) th, .md-typeset table:not([class]) td { padding: 0.35em 0.6em; overflow-wrap: anywhere; min-width: 4em; }
.md-typeset table:not([class]) code { font-size: 0.95rem; }
.md-typeset img { max-width: 100%; max-height: 12cm; }
.entry { display: flex; margin: 0.15em 0; break-inside: avoid; } .part { font-weight: bold; margin: 0.7em 0 0.2em; break-after: avoid; }
.entry i { flex: 1; border-bottom: 1px dotted #999; margin: 0 0.5em 0.35em; }
.front h1 { margin-bottom: 2rem; }
"""
FOOT = """<div style="font: 8px sans-serif; width: 100%; padding: 0 15mm; display: flex; justify-content: space-between; color: #555">
<span>{title}</span><span><span class="pageNumber"></span> of <span class="totalPages"></span></span></div>"""


@dataclass(frozen=True)
class Chapter:
    """An entry of the contents: a page, or a part of the menu above some of them.

    Attributes:
        title: as in the menu.
        depth: of the menu, 0 at its top.
        page: address in the site; empty where it is no page.
    """

    title: str
    depth: int
    page: str = ""


def chapters(menu: list[Any], site: Path, depth: int = 0) -> Iterator[Chapter]:
    """The entries of a menu as mkdocs.yml has it, one after the other."""
    for entry in menu:
        title, inside = next(iter(entry.items())) if isinstance(entry, dict) else ("", entry)
        if isinstance(inside, list):
            yield Chapter(title, depth)
            yield from chapters(inside, site, depth + 1)
        elif inside not in LEFT_OUT:
            page = inside.removesuffix(".md") + ".html"
            yield Chapter(title or _heading(site / page), depth, page)
            if inside in BELOW:
                for linked in re.findall(r'href="(examples/[^"#]+\.html)', (site / page).read_text(encoding="utf-8")):
                    yield Chapter(_heading(site / linked), depth + 1, linked)


def _heading(page: Path) -> str:
    found = re.search(r"<h1[^>]*>(.*?)(?:<a class=\"headerlink|</h1>)", page.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None, page
    return re.sub("<[^>]*>", "", found[1]).strip()


def write(path: Path, site: Path, menu: list[Any], browser: Any) -> dict[str, int]:
    """Print the manual of a built site into a file. Returns the page of the manual on which each page of the site begins.

    It is printed twice: the first print tells the page numbers, the second one has them in its contents.
    """
    parts = list(dict.fromkeys(chapters(menu, site)))
    given = [
        {"title": each.title, "depth": each.depth, "page": each.page, "html": each.page and (site / each.page).read_text(encoding="utf-8")}
        for each in parts
    ]
    title = f"pinpress {pp.__version__}: manual"
    tab, numbers = browser.new_page(), {}
    for _ in range(2):
        tab.goto((site / "index.html").as_uri())
        tab.evaluate(ASSEMBLE, [given, title, numbers])
        tab.add_style_tag(content=STYLE)
        lost = tab.evaluate(LOST)
        assert lost == [], lost
        margin = {"top": "16mm", "bottom": "18mm", "left": "15mm", "right": "15mm"}
        header = {"display_header_footer": True, "header_template": "<span></span>", "footer_template": FOOT.format(title=title)}
        print_out = tab.pdf(format="A4", margin=margin, outline=True, tagged=True, **header)
        before, numbers = numbers, first_pages(print_out, [each.page for each in parts if each.page])
    tab.close()
    assert before == numbers, "the contents took another number of pages when they had page numbers"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(print_out)
    return numbers


def first_pages(content: bytes, names: list[str]) -> dict[str, int]:
    """Numbers of the pages on which named places of a PDF file of Chromium stand, from 1 on; its objects are plain text."""
    objects = {int(number): body for number, body in re.findall(rb"(?:^|\n)(\d+) 0 obj\n(.*?)\nendobj", content, re.DOTALL)}

    def reference(body: bytes, key: bytes) -> int:
        found = re.search(rb"/" + key + rb" (\d+) 0 R", body)
        assert found is not None, key
        return int(found[1])

    def leaves(number: int) -> Iterator[int]:
        kids = re.search(rb"/Kids \[(.*?)\]", objects[number], re.DOTALL)
        if kids is None:
            yield number
            return
        for kid in re.findall(rb"(\d+) 0 R", kids[1]):
            yield from leaves(int(kid))

    catalog = next(body for body in objects.values() if b"/Type /Catalog" in body)
    order = {number: k for k, number in enumerate(leaves(reference(catalog, b"Pages")), 1)}
    places = re.findall(rb"/(\S+) \[(\d+) 0 R /XYZ", objects[reference(catalog, b"Dests")])
    at = {
        re.sub(rb"#([0-9A-F]{2})", lambda code: bytes.fromhex(code[1].decode()), name).decode(): order[int(page)] for name, page in places
    }
    return {name: at[name] for name in names}


def main(quick: bool = False) -> None:
    """Print the manual of the built site; ``quick``: its first pages."""
    from mkdocs.config import load_config  # optional

    path = (OUT[0] if OUT else ROOT / "out") / "manual.pdf"
    with chromium() as browser:
        pages = write(path, ROOT / "out" / "site", load_config(str(ROOT / "mkdocs.yml")).nav[: 2 if quick else None], browser)
    print(f"{path}: {path.stat().st_size / 1e6:.1f} MB, {len(pages)} chapters, the last from page {max(pages.values())} on")
