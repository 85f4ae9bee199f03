"""The documents from which the shipped presses come, and what pinpress makes of every table and figure in them.

    python tests/validation/validate.py                        # all three, as text
    python tests/validation/validate.py kong2025               # one
    python tests/validation/validate.py --out docs             # pages with figures

Each document is a module with a function `page`; the classes of which a page consists stand in `pages`.
"""

from importlib import import_module

from pinpress.common.errors import UnknownNameError
from validation.pages import Page

DOCUMENTS = ("kong2025", "zhang2007", "chen2002")


def reproduced(document: str) -> Page:
    """Work out the page of a document.

    Args:
        document: one of `DOCUMENTS`.

    Raises:
        UnknownNameError: there is no such document.
    """
    if document not in DOCUMENTS:
        raise UnknownNameError("document", document, DOCUMENTS)
    page: Page = import_module(f".{document}", __name__).page()  # only the one that is asked for: they are slow to import
    return page
