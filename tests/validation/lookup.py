"""Rows of the documents by their quantities, and the reference numbers of `tests/reference`."""

import json
from pathlib import Path

from validation.rows import rows_of


def row(document, words):
    """The only row with this quantity."""
    (only,) = [row for row in rows_of(document.PARTS) if row.quantity == words]
    return only


def reference(name):
    """Numbers that were computed without pinpress."""
    return json.loads((Path(__file__).parents[1] / "reference" / f"{name}.json").read_text(encoding="utf-8"))
