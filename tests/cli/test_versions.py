"""`pinpress --version` against the metadata of packages and the files that go into pages."""

import re
from importlib import metadata

import numpy
import pinocchio
import pytest

from pinpress.cli import versions
from pinpress.cli.main import main
from pinpress.common.errors import PinpressError
from pinpress.visual import licences, pages


def said(capsys) -> dict[str, list[str]]:
    """The columns of each line by the first."""
    with pytest.raises(SystemExit, match="0"):
        main(["--version"])
    return {cells[0]: cells[1:] for line in capsys.readouterr().out.splitlines() if (cells := re.split(r" {3,}", line.strip()))}


def test_versions_are_those_that_run(capsys):
    found = said(capsys)
    assert found["numpy"][0] == numpy.__version__
    assert found["pin"][0] == pinocchio.__version__
    assert found["pin"][1] == "BSD-3-Clause"
    assert f"pinpress {metadata.version('pinpress')}, MIT" in found


def test_packages_are_those_that_the_extras_of_users_name(capsys):
    found = said(capsys)
    assert {"clarabel", "lazy-loader", "meshcat", "plotly", "matplotlib", "pandas", "pyarrow", "asammdf"} <= found.keys()
    assert not {"pytest", "mujoco", "mkdocs", "ruff"} & found.keys()
    assert found["meshcat"][2].startswith("for recording")


def test_licences_in_pages_are_those_of_their_files(capsys):
    found = said(capsys)
    for part in licences.of_meshcat(pages.meshcat_script()):
        assert found[part.name] == ([part.version, part.licence] if part.version else [part.licence])
    assert {"three", "dat.gui", "msgpack-lite"} <= found.keys()
    assert found["three"][1] == "MIT"
    assert 'const i="132"' in pages.meshcat_script().read_text("utf-8")  # three.js's own word for its revision
    assert found["three"][0].startswith("0.132.")
    version, licence = found["plotly.js"]
    assert f"plotly.js v{version}\n" in pages.plotly().licence
    assert licence == "MIT"


def test_parts_of_plotly_stand_under_their_licences(capsys):
    with pytest.raises(SystemExit, match="0"):
        main(["--version"])
    lines = capsys.readouterr().out.partition("In plotly.js ")[2].splitlines()
    shown, licence = {}, ""
    for line in lines[1:]:
        if line.startswith("    "):
            shown |= dict.fromkeys(line.strip().rstrip(",").split(", "), licence)
        else:
            licence = line.strip()
    parts = licences.of_plotly(licences.plotly_version(pages.plotly_head()))
    assert lines[0] == licences.plotly_version(pages.plotly_head())
    assert shown == {f"{part.name} {part.version}".strip(): part.licence for part in parts}


def test_a_plotly_whose_parts_are_not_known_is_said_to_be_so(monkeypatch, capsys):
    monkeypatch.setattr(versions, "plotly_head", lambda: "/**\n* plotly.js v99.0.0\n* Licensed under the MIT license\n")
    with pytest.raises(SystemExit, match="0"):
        main(["--version"])
    assert f"In plotly.js {' or '.join(licences.examined())}\n" in capsys.readouterr().out


def test_says_what_is_not_installed(monkeypatch, capsys):
    def nowhere():
        raise PinpressError("not installed")

    monkeypatch.setattr(versions, "meshcat_script", nowhere)
    monkeypatch.setattr(versions, "plotly_head", nowhere)
    found = said(capsys)
    assert found["Meshcat"] == found["plotly.js"] == ["not installed"]
    assert versions.stated("no-such-package-anywhere") == ("not installed", "")


def test_of_a_checkout_without_metadata(monkeypatch, capsys):
    def none(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "requires", none)
    assert "(the package is not installed)" in said(capsys)


@pytest.mark.parametrize(
    ("fields", "licence"),
    [
        ({"License-Expression": "MIT", "License": "other"}, "MIT"),
        ({"Classifier": "License :: OSI Approved :: BSD License", "License": "BSD\nRedistribution and use"}, "BSD License"),
        ({"License": "MIT\nPermission is hereby granted"}, "MIT"),
        ({}, "not stated"),
    ],
)
def test_a_licence_is_what_the_package_states(monkeypatch, fields, licence):
    from email.message import Message

    message = Message()
    message["Version"] = "1.0"
    for name, value in fields.items():
        message[name] = value
    monkeypatch.setattr(metadata, "metadata", lambda name: message)
    assert versions.stated("any") == ("1.0", licence)
