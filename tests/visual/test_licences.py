"""The list of what pages hold of others is that of the bundles themselves, and the pages have its licences in words."""

import re

import pytest

from pinpress.visual import licences, pages

SPDX = {"MIT", "ISC", "BSD-2-Clause", "BSD-3-Clause", "Apache-2.0", "MIT OR Apache-2.0", "Zlib", "BSL-1.0", "Unlicense", "CC-BY-2.0"}
OWN = {"LicenseRef-NeuQuant"}  # a licence of one package alone, in the form that SPDX has for such
NAMELESS = {"Unlicense", "BSL-1.0", "Apache-2.0"}  # texts that need no holder, or packages that name none


def in_meshcat() -> dict[str, licences.Part]:
    return {part.name: part for part in licences.of_meshcat(pages.meshcat_script())}


def in_plotly() -> dict[str, licences.Part]:
    return {part.name: part for part in licences.of_plotly(licences.plotly_version(pages.plotly_head()))}


def test_meshcats_parts_are_all_whose_modules_its_bundle_names() -> None:
    """The bundle for developers, of the same sources, has the path of each module."""
    unminified = pages.meshcat_script().with_name("main.js").read_text("utf-8")
    named = set(re.findall(r'"\./node_modules/((?:@[\w.-]+/)?[\w.-]+)/', unminified))
    assert {"three", "dat.gui", "three-wtm"} <= named
    assert named - in_meshcat().keys() == set()


@pytest.mark.parametrize(
    ("part", "trace", "file"),
    [
        ("gif.js", "GIFEncoder", "main.min.js"),
        ("NeuQuant", "NeuQuant", "main.min.js"),
        ("tar-js", "ustar", "main.min.js"),
        ("download.js", "msSaveBlob", "main.min.js"),
        ("earcut", "earcutLinked", "main.js"),  # the other has no names of functions
    ],
)
def test_what_stands_inside_meshcats_parts_is_named_too(part: str, trace: str, file: str) -> None:
    """Copies of others' files in packages that say nothing of them."""
    assert part in in_meshcat()
    assert trace in pages.meshcat_script().with_name(file).read_text("utf-8")


def test_plotlys_parts_are_those_of_its_version() -> None:
    """A bundle whose parts nobody has looked up is not shipped: python docs/make.py page_licences with both versions writes the list."""
    assert licences.plotly_version(pages.plotly_head()) in licences.examined()


def test_plotlys_parts_are_all_that_its_bundle_names() -> None:
    bundle = pages.plotly_script().read_text("utf-8")
    named = set(re.findall(r"^((?:@[\w.-]+/)?[\w.-]+)/\S+\.m?js:$", bundle.rpartition("Bundled license information:")[2], re.MULTILINE))
    named |= set(re.findall(r"^/\*!\n \* ([\w-]+) <https", bundle, re.MULTILINE))
    assert len(named) > 5
    assert named - in_plotly().keys() == set()


def test_parts_of_another_version_are_those_of_all_that_are_known() -> None:
    every = {part.name for version in licences.examined() for part in licences.of_plotly(version)}
    assert {part.name for part in licences.of_plotly("99.0.0")} == every
    assert {part.name for part in licences.of_plotly(licences.examined()[0])} < every


@pytest.mark.parametrize("parts", [in_meshcat, in_plotly])
def test_each_part_has_an_spdx_expression_a_holder_and_a_text(parts) -> None:
    for part in parts().values():
        assert part.licence in SPDX | OWN, part
        assert len(part.text) > 130, part
        assert part.licence in NAMELESS or re.search(r"(?i)copyright|\(c\)|©|\bby \w", part.notice + part.text[:600]), part


@pytest.mark.parametrize(("library", "parts"), [(pages.meshcat, in_meshcat), (pages.plotly, in_plotly)])
def test_pages_have_every_part_and_each_text_once(library, parts) -> None:
    licence = library().licence
    for part in parts().values():
        assert re.search(rf"^{re.escape(f'{part.name} {part.version}'.strip())}(:|$)", licence, re.MULTILINE), part
        assert part.notice in licence
        assert licence.count(part.text) == 1, part
