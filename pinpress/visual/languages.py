"""The language of a page: its English texts, translated with a catalogue of phrases.

A catalogue is `templates/phrases_<language>.tsv`: each line has the English phrase, a tab, and the translation. ``{}`` in a phrase is a
placeholder for any part of a text, which is translated separately. If the order changes, ``{1}`` and ``{2}`` in the translation are the
first and the second part. A text that is not a phrase is translated piece by piece, between its commas and full stops. Text without a
phrase stays unchanged: names of bearings and links, and texts of users.
"""

from __future__ import annotations

import importlib.resources
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

LANGUAGES = {"en": "English", "de": "German", "zh": "Chinese", "ja": "Japanese"}
WITH_COMMA = ("de",)  # languages that write 0.5 as 0,5
PLACE = "{}"
# A text that is not a phrase is split at these separators, in this order: at its unit, and into sentences and clauses.
CLAUSES = [re.compile(between) for between in (r"( \[[^]]*\]$)", r"(\. |\.$|\n)", "(; )")]
# A text that is not a phrase with placeholders either is split here: into the parts of a list.
PARTS = [re.compile(between) for between in ("(: )", "(, )")]
NUMBER = re.compile(r"(?<![\w.])([-\u2212]?\d+)\.(\d+)(?![\w.]*\.\d)")  # but not a version such as 0.2.0
OF_CODE = re.compile(r"\w+\(\w+=")  # an object as Python writes it

# The texts in the data of a page are the values of these keys; for the last keys also the items of lists.
TEXTS = ("title", "note", "heads", "rows", "value", "at", "across", "up", "quantity", "subtitle", "open", "above")
NAMES = ("name", "link")
LISTS = ("places", "x", "y")


@dataclass(frozen=True)
class Language:
    """A language and its phrases.

    Attributes:
        code: code of the language, such as "de".
        phrases: English phrase -> its translation.
    """

    code: str
    phrases: Mapping[str, str]

    @cached_property
    def _patterns(self) -> list[tuple[re.Pattern[str], str]]:
        """Phrases with placeholders, those with the most fixed words first. A placeholder does not match the end of a sentence or clause;
        in a phrase with only a short word, such as "of {}", it does not match a comma either."""
        own = {phrase: len(phrase.replace(PLACE, "").strip()) for phrase in self.phrases if PLACE in phrase}
        places = {phrase: rf"((?:(?!; |\. {'|, ' if own[phrase] < 4 else ''}).)+?)" for phrase in own}
        open_ones = sorted(own, key=lambda phrase: -own[phrase])
        return [(re.compile(places[phrase].join(map(re.escape, phrase.split(PLACE)))), self.phrases[phrase]) for phrase in open_ones]

    def said(self, text: str) -> str:
        """An English text in this language."""
        if OF_CODE.search(text):
            return text
        return self._with_comma(self._said(text))

    def _said(self, text: str) -> str:
        for find in (self._phrase, self._clauses, self._open_phrase, self._parts):
            if (found := find(text)) is not None:
                return found
        return text

    def _phrase(self, text: str) -> str | None:
        """The catalogue's translation of a text, which may begin a sentence; None if the text is not a phrase."""
        if text in self.phrases:
            return self.phrases[text]
        found = self.phrases.get(text[:1].lower() + text[1:])
        return found and found[0].upper() + found[1:]

    def _open_phrase(self, text: str) -> str | None:
        """`_phrase` for phrases with placeholders."""
        for pattern, translation in self._patterns:
            for start in dict.fromkeys((text, text[:1].lower() + text[1:])):
                if match := pattern.fullmatch(start):
                    return self._filled(translation, [self._said(part) for part in match.groups()], capital=start != text)
        return None

    @staticmethod
    def _filled(translation: str, parts: Sequence[str], capital: bool) -> str:
        by_number = re.sub(r"\{(\d)\}", lambda place: parts[int(place[1]) - 1], translation)
        left = iter(parts)
        whole = re.sub(r"\{\}", lambda _: next(left), by_number)
        return whole[0].upper() + whole[1:] if capital else whole

    def _clauses(self, text: str) -> str | None:
        return self._between(CLAUSES, text)

    def _parts(self, text: str) -> str | None:
        return self._between(PARTS, text)

    def _between(self, separators: Sequence[re.Pattern[str]], text: str) -> str | None:
        """A text translated piece by piece; None if it contains no separator."""
        pieces = next((pieces for between in separators if len(pieces := between.split(text)) > 1), None)
        return None if pieces is None else "".join(piece if k % 2 else self._said(piece) for k, piece in enumerate(pieces))

    def _with_comma(self, text: str) -> str:
        if self.code not in WITH_COMMA or not NUMBER.search(text):
            return text
        return NUMBER.sub(r"\1,\2", re.sub(r"(\d), (?=[-\u2212]?\d)", r"\1; ", text))  # ";" separates

    def of_page(self, data: Mapping[str, Any], template: str) -> dict[str, Any]:
        """The data of a page with its texts in this language, and the words of the page's template."""
        words = {text: said for text in shown_by(template) if (said := self.said(text)) != text}
        return {**_mapped(data, self.said), "language": {"code": self.code, "words": words, "comma": self.code in WITH_COMMA}}


@cache
def language(code: str) -> Language:
    """A language by its code, one of `LANGUAGES`; English has no phrases."""
    file = importlib.resources.files(__package__) / "templates" / f"phrases_{code}.tsv"
    lines = file.read_text("utf-8").splitlines() if code != "en" else []
    return Language(code, dict(line.split("\t") for line in lines))


def shown_by(template: str) -> list[str]:
    """The English texts that a template shows: between its elements, in attributes, and in its scripts."""
    html = re.sub(r"<(script|style)\b.*?</\1>", "", template, flags=re.DOTALL)
    found = re.findall(r'\bsay\("([^"]+)"\)', template)
    found += re.findall(r'(?:title|aria-label)="([^"{]+)"', html)
    return found + [text for part in re.findall(r">([^<>{}]+)<", html) if re.search(r"[A-Za-z]{2}", text := part.strip())]


def _mapped(data: Any, said: Callable[[str], str], key: str = "") -> Any:
    """The data of a page with its texts replaced by a function; ``key``: the key under which ``data`` is found."""
    if isinstance(data, str):
        return said(data) if key in TEXTS or key in NAMES else data
    if isinstance(data, list | tuple):
        return [_mapped(each, said, "title" if key in LISTS else key) for each in data]
    if isinstance(data, Mapping):
        bars = ("bars", "before") if data.get("kind") == "bars" else ()  # in bar charts the names of series are keys
        return {
            name: {said(series): values for series, values in each.items()} if name in bars and each else _mapped(each, said, name)
            for name, each in data.items()
        }
    return data
