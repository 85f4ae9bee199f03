"""The header of a report: company, drawing, author and date."""

from __future__ import annotations

import base64
import os
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any
from xml.etree import ElementTree

from ...common import files
from ...common.errors import PinpressError, odd_character, shown
from ..languages import LANGUAGES

LARGEST = 1_000_000  # largest size of a logo [bytes]
BEGINNINGS = {b"\x89PNG\r\n\x1a\n": "png", b"\xff\xd8\xff": "jpeg"}
ROOT = "{http://www.w3.org/2000/svg}svg"
WRITE = "give a PNG, JPEG or SVG file of at most 1 MB"


@dataclass(frozen=True)
class Header:
    """Title of a report, and the title block at the top of the page and of its first printed sheet. Each part may be left out.

        pp.report(press, motion, "report.html", header=pp.Header(title="Press 3", company="Muster AG", logo="logo.svg", drawing="4711-03"))

    Attributes:
        title: heading of the page in place of the press's name.
        company: owner of the page.
        logo: path of a PNG, JPEG or SVG file of at most 1 MB, which becomes part of the page; it is read when the header is made.
        drawing: number of the drawing.
        author: author of the page.
        revision: revision of the page.
        date: date, as text that is shown unchanged.
        notes: any text; its line ends are kept.
        language: language of the page: "en", "de", "zh" or "ja" (English, German, Chinese, Japanese); your own texts are not translated.

    Raises:
        PinpressError: a part is not text, the language is unknown, or the logo cannot be read, is not such a picture or is larger than 1
            MB.
    """

    title: str = ""
    company: str = ""
    logo: str | os.PathLike[str] | None = None
    drawing: str = ""
    author: str = ""
    revision: str = ""
    date: str = ""
    notes: str = ""
    language: str = "en"

    def __post_init__(self) -> None:
        for name in (field.name for field in fields(self) if field.name != "logo"):
            text = getattr(self, name)
            if not isinstance(text, str):
                raise PinpressError(f'Header: {name} is {shown(text)}: give a text, such as {name}="..."')
            if odd := odd_character(text, with_control=False):
                raise PinpressError(f"Header: {name} has the character {odd}, which pages cannot show: leave it out")
        if self.language not in LANGUAGES:
            raise PinpressError(f"Header: language is {shown(self.language)}: write one of {', '.join(LANGUAGES)}")
        _ = self.picture

    @cached_property
    def picture(self) -> str | None:
        """The logo as a data URL."""
        if self.logo is None:
            return None
        path = files.path_of("Header: logo", self.logo)
        try:
            content = files.read(path, LARGEST)
        except (OSError, ValueError) as error:  # ValueError: a null character in the path
            raise PinpressError(f"Header: logo is {path}, which cannot be read: {files.reason(error)}; {WRITE}") from error
        kind = next((kind for beginning, kind in BEGINNINGS.items() if content.startswith(beginning)), None)
        if kind is None and not _is_svg(content):
            raise PinpressError(f"Header: logo is {path}, which is no PNG, JPEG or SVG picture; {WRITE}")
        return f"data:image/{kind or 'svg+xml'};base64,{base64.b64encode(content).decode('ascii')}"

    def block(self) -> dict[str, Any] | None:
        """The title block below the title, as data of a page; None if it is empty."""
        rows = [[name.capitalize(), _line(getattr(self, name))] for name in ("drawing", "revision", "author", "date")]
        parts = {"logo": self.picture, "company": _line(self.company), "rows": [row for row in rows if row[1]], "notes": self.notes.strip()}
        return parts if any(parts.values()) else None

    def heading(self, press: str) -> str:
        """The title in one line, or the press's name."""
        return _line(self.title) or press


def _line(text: str) -> str:
    return " ".join(text.split())


def _is_svg(content: bytes) -> bool:
    try:
        return ElementTree.fromstring(content).tag == ROOT
    except (ElementTree.ParseError, ValueError, LookupError):  # LookupError: an encoding that Python does not know
        return False
