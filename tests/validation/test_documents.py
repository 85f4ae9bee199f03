"""The pages of the three documents: complete, within the tolerances they state, what their command writes, and right.

What is right is known from `tests/reference` (computed without pinpress), from closed forms written here, and from sums of printed numbers.
"""

import re
from dataclasses import replace
from pathlib import Path

import pytest
from support import markdown
from support.sampling import rest_exhaustive
from validation import (
    chen2002,
    kong2025,
    pictures,
    rows,
    validate,
    zhang2007,
)
from validation.rows import (
    BEYOND,
    CONFIRMED,
    DATA,
    FINDINGS,
    NOT,
    PARTLY,
    REPRODUCED,
    UNPRINTED,
    VERDICTS,
    Part,
    Row,
)

import pinpress as pp

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
DOCUMENTS = {"kong2025": kong2025, "zhang2007": zhang2007, "chen2002": chen2002}


def numbered(chapter, *numbers):
    return [f"Fig. {chapter}-{k}" for k in numbers]


# Every table and figure of the documents, by their own numbers; where one is captioned twice, with the number it should have.
NUMBERS = {
    "kong2025": [*(f"Fig. {k}" for k in range(1, 7)), "Table 1", "Table 2", "Table 3"],
    "zhang2007": [
        *numbered(1, *range(1, 5)),
        *numbered(2, *range(1, 19)),
        *numbered(3, *range(1, 9)),
        *numbered(4, *range(4, 13)),
        *numbered(5, *range(1, 16)),
        "Table 4-1",
        "Table 5-1",
        "Table 5-2",
    ],
    "chen2002": ["Fig. 1", "Fig. 2", "Fig. 3"],
}


SHORT = rest_exhaustive(DOCUMENTS, "kong2025")  # the runs of the second and the searches of the third take seconds
ROWS = [
    pytest.param(row, id=f"{name}: {row.quantity}", marks=[] if name == "kong2025" else pytest.mark.exhaustive)
    for name, document in DOCUMENTS.items()
    for row in rows.rows_of(document.PARTS)
    if row.within is not None
]


# ------------------------------------------------------------------------------------------------------------------- rows and pages


@pytest.mark.parametrize("row", ROWS)
def test_what_counts_as_reproduced_is(row):
    assert row.holds, f"{row.quantity}: {row.value} for {row.printed}"
    assert row.within <= 1.0  # per cent


@pytest.mark.parametrize("name", SHORT)
def test_pages_have_the_tables_that_the_command_writes(name):
    """`python tests/validation/validate.py --write`."""
    document = DOCUMENTS[name]
    page = (DOCS / f"{name}.md").read_text(encoding="utf-8")
    assert page == rows.fill(page, document.PARTS, document.MAIN)
    assert f"`tests/validation/{name}.md`" in page
    all_rows = (ROOT / "tests" / "validation" / f"{name}.md").read_text(encoding="utf-8")
    assert all_rows == rows.complete(name, document.PARTS, document.NO_RESULTS)


@pytest.mark.parametrize("name", DOCUMENTS)
def test_every_table_and_figure_has_its_place_once(name):
    document = DOCUMENTS[name]
    numbers = [number for title in (*(part.title for part in document.PARTS), document.NO_RESULTS) for number in numbers_of(title)]
    assert len(numbers) == len(set(numbers))
    assert sorted(numbers) == sorted(NUMBERS[name])


def numbers_of(title):
    """Numbers of tables and figures in a title, such as Fig. 2-7 to 2-15."""
    for kind, first, last in re.findall(r"(Fig\.|Table) (\d+(?:-\d+)?)(?: to ([\d-]+))?", title.partition(": ")[0]):
        if not last:
            yield f"{kind} {first}"
            continue
        (chapter, low), (_, high) = (number.split("-") for number in (first, last))
        yield from (f"{kind} {chapter}-{k}" for k in range(int(low), int(high) + 1))


@pytest.mark.parametrize("name", DOCUMENTS)
def test_verdicts_say_what_the_rows_do(name):
    for part in DOCUMENTS[name].PARTS:
        claimed = [row.within is not None for row in part.rows if row.number is not None and not row.source]
        assert part.verdict in VERDICTS
        assert {
            REPRODUCED: bool(claimed) and all(claimed),
            CONFIRMED: not any(claimed) and all(row.within is not None for row in part.rows if row.source),
            UNPRINTED: not claimed,
            PARTLY: any(claimed) and not all(claimed),
            NOT: not any(claimed),
            DATA: not any(claimed),
            FINDINGS: not claimed,
            BEYOND: not any(claimed),
        }[part.verdict], part.title


@pytest.mark.exhaustive
def test_the_page_on_mounts_has_the_findings_of_the_frame():
    text = (ROOT / "viz" / "foundation.md").read_text(encoding="utf-8")
    says = list(zhang2007.vibration_rows())
    assert len(says) == text.partition("| Zhang 2007 says")[2].partition("\n\n")[0].count("\n") - 1
    for row in says:
        gives, _, agrees = str(row.value).partition(". Agrees: ")
        assert f"| {row.quantity.partition(': ')[2]} | {gives} | {agrees} |" in text


def test_pictures_of_the_pages_are_those_that_the_command_draws():
    drawn = {picture for document in DOCUMENTS.values() for picture in document.PICTURES}
    assert {path.stem for path in (DOCS / "figures").iterdir()} == drawn
    pages = "".join((DOCS / f"{name}.md").read_text(encoding="utf-8") for name in DOCUMENTS)
    assert sorted(re.findall(r"\(figures/(\w+)\.png\)", pages)) == sorted(drawn)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", DOCUMENTS)
def test_pictures_are_drawn(name, tmp_path):
    for picture, draw in DOCUMENTS[name].PICTURES.items():
        pictures.save(draw(), tmp_path / f"{picture}.png")
        assert (tmp_path / f"{picture}.png").read_bytes().startswith(b"\x89PNG")
        assert 5_000 < (tmp_path / f"{picture}.png").stat().st_size < 100_000


def test_command_prints_and_fails_where_a_number_does_not_hold(monkeypatch, capsys):
    good = Part("Table 1: one", REPRODUCED, [Row("length [m]", "2.00", lambda: 2.01, 1.0)])
    monkeypatch.setattr(kong2025, "PARTS", (good,))
    assert validate.main(["kong2025"]) == 0
    assert "| length [m] | 2.00 | 2.01 | +0.50 % | 1 % |" in capsys.readouterr().out
    bad = replace(good, rows=[Row("length [m]", "2.00", lambda: 2.03, 1.0)])
    monkeypatch.setattr(kong2025, "PARTS", (bad,))
    assert validate.main(["kong2025"]) == 1
    assert "length [m] is 2.03, not 2.00" in capsys.readouterr().err


def test_command_refuses_unknown_documents(capsys):
    with pytest.raises(SystemExit, match="2"):
        validate.main(["kong2026"])
    assert "kong2026" in capsys.readouterr().err


def test_a_page_needs_its_marks_and_its_quantities_once():
    with pytest.raises(pp.PinpressError, match="end of rows"):
        rows.fill("words\n", (), {})
    twice = Part("Fig. 1: twice", UNPRINTED, [Row("a", "", lambda: 1.0), Row("a", "", lambda: 2.0)])
    with pytest.raises(pp.PinpressError, match=r"Fig\. 1 must have each of these quantities once: a"):
        rows.fill("words\n", [twice], {"Fig. 1": ("a",)})


@pytest.mark.parametrize(
    ("given", "cells"),
    [
        (Row("a", "-2.50", lambda: -2.5), ("a", "-2.50", "", "-2.50", "0.00 %", "")),
        (Row("a", "-2.50", lambda: -2.6, 5.0), ("a", "-2.50", "", "-2.60", "-4.00 %", "5 %")),
        (Row("a", "10 000", lambda: 10001.0), ("a", "10 000", "", "10001", "+0.01 %", "")),
        (Row("a", "0", lambda: 0.0, 0), ("a", "0", "", "0", "", "rounding")),
        (Row("a", "0.0", lambda: -1e-9, places=1), ("a", "0.0", "", "0.0", "", "")),
        (Row("a", "more", lambda: 1.25, places=1), ("a", "more", "", "1.2", "", "")),
        (Row("a", "1", lambda: 1.0, source="formula"), ("a", "", "1 (formula)", "1", "0.00 %", "")),
        (Row("a", "", lambda: "strong"), ("a", "", "", "strong", "", "")),
    ],
)
def test_cells(given, cells):
    assert given.cells() == cells


@pytest.mark.parametrize(
    ("given", "holds"),
    [
        (Row("a", "100", lambda: 101.0, 1.0), True),
        (Row("a", "100", lambda: 101.1, 1.0), False),
        (Row("a", "-100", lambda: -98.9, 1.0), False),
        (Row("a", "0", lambda: 0.0, 0), True),
        (Row("a", "0", lambda: 1e-12, 0), False),
        (Row("a", "100", lambda: 200.0), None),
    ],
)
def test_holds(given, holds):
    assert given.holds is holds


@pytest.mark.parametrize(("printed", "within"), [("more", 1.0), ("0", 1.0), ("1", 0)])
def test_refuses_a_tolerance_without_a_printed_number(printed, within):
    with pytest.raises(pp.PinpressError, match="tolerance"):
        Row("a", printed, lambda: 1.0, within)


def test_refuses_a_tolerance_of_words():
    with pytest.raises(pp.PinpressError, match="tolerance"):
        Row("a", "1", lambda: "one", 1.0).value  # noqa: B018


def test_table_escapes_bars():
    assert markdown.table(("a",), [("|x|",)]) == "| a |\n|---|\n| \\|x\\| |"


@pytest.mark.exhaustive
def test_printed_numbers_that_are_held():
    """What the README says of the documents: printed numbers, and those of formulas and of solvers without pinpress."""
    held = {name: [row for row in rows.rows_of(document.PARTS) if row.holds] for name, document in DOCUMENTS.items()}
    assert {name: sum(not row.source for row in kept) for name, kept in held.items()} == {"kong2025": 11, "zhang2007": 0, "chen2002": 3}
    assert sum(bool(row.source) for kept in held.values() for row in kept) == 108
