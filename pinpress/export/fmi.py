"""A press's table as an FMU: FMI 2.0 for Model Exchange and Co-Simulation, with its sources, and a binary where a compiler is found."""

from __future__ import annotations

import hashlib
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np

from ..common import files
from ..common.arguments import typed
from ..common.errors import PinpressError, caution, shown
from ..common.files import path_of
from .c_source import code_of, filled, header_lines, identifiers
from .tables import ACCELERATION, FORCES, SPEED, SQUARE, PressTable

STEM = "press"  # of the C inside, whatever the FMU is called
TOLERANCE = 1e-12  # of Co-Simulation, in rad or m and in a share of the speed: a falling press magnifies errors ten thousand times
STAMP = (1980, 1, 1, 0, 0, 0)  # of the files in the archive, so that the same press gives the same bytes
ENDINGS = {"linux": ".so", "darwin": ".dylib", "win": ".dll"}
HOSTS = {"linux": "linux", "darwin": "darwin", "win32": "win"}
UNITS = {  # exponents of SI units
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "rad/s2": {"rad": 1, "s": -2},
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N m": {"kg": 1, "m": 2, "s": -2},
    "kg": {"kg": 1},
    "kg m2": {"kg": 1, "m": 2},
}


class Value(NamedTuple):
    """A scalar variable of the FMU; those that depend on states and inputs have these, by their numbers from 1, as ``dependencies``."""

    name: str
    unit: str
    causality: str
    attributes: dict[str, str]
    real: dict[str, str]
    dependencies: tuple[int, ...] | None = None


@typed
def fmu(table: PressTable, path: str | os.PathLike[str], *, compiler: str | None = "cc", platform: str | None = None) -> Path:
    """Write a press as an FMU of FMI 2.0, and return its path.

    Its states are the driver's position and speed, its inputs the torque on the driver and the inputs of the table. Start values of both
    states, ``added_inertia`` of flywheel and motor at the driver, and the ``tolerance`` of Co-Simulation are parameters. Outputs are the
    acceleration and all that the table has. Motors and process laws are outside. Co-Simulation takes inputs as constant over a step.

    Args:
        table: the press.
        path: the .fmu file; a file of this name is replaced.
        compiler: command of a C compiler that takes gcc's options, with options of its own; without it, or with None, the FMU has sources
            alone.
        platform: FMI's name of the platform for which the compiler compiles: linux64, darwin64, win64 or one with 32; None: this machine.

    Raises:
        PinpressError: the path does not end in .fmu or cannot be written; an unknown platform; the compiler reports an error.

    Warns:
        PinpressWarning: the compiler is not found, so that the FMU has sources alone.
    """
    target = Path(path_of("path", path))
    if target.suffix != ".fmu":
        raise PinpressError(f"path is {target}: give a name that ends in .fmu")
    known = [f"{system}{bits}" for system in ENDINGS for bits in (32, 64)]
    if platform is not None and not (isinstance(platform, str) and platform in known):
        raise PinpressError(f"platform is {shown(platform)}: give {', '.join(known)}")
    named = platform or f"{HOSTS.get(sys.platform, sys.platform)}{64 if sys.maxsize > 2**32 else 32}"
    command = _command(compiler)
    identifier = re.sub(r"[^A-Za-z0-9_]", "_", target.stem)
    identifier = identifier if re.match("[A-Za-z]", identifier) else f"press_{identifier}"
    code = code_of(table, STEM)
    values = _values(table, code.outputs)
    low, high = float(table.functions.borders[0]), float(table.functions.borders[-1])
    start = 0.0 if table.functions.period is not None or low <= 0.0 <= high else 0.5 * (low + high)
    lines = "\n".join(f" * {line}".rstrip() for line in header_lines(table))
    given = {"HEADER": lines, "FILE": STEM, "PREFIX": STEM, "MACRO": STEM.upper(), "NAME": identifier, "TOLERANCE": repr(TOLERANCE)}
    given |= {"ANGLE": repr(start), "GUID": "of all the rest"}
    guid = hashlib.sha256("".join((filled("fmu.c", given), code.source, code.header, repr(values))).encode()).hexdigest()[:32]
    source = filled("fmu.c", given | {"GUID": guid})
    sources = {"fmu.c": source, f"{STEM}.c": code.source, f"{STEM}.h": code.header}
    content = {"modelDescription.xml": _description(table, identifier, guid, values, start)}
    content |= {f"sources/{name}": text.encode() for name, text in sources.items()}
    if compiler is not None:
        if command and shutil.which(command[0]):
            ending = next(ending for system, ending in ENDINGS.items() if named.startswith(system)) if named in known else ".so"
            content[f"binaries/{named}/{identifier}{ending}"] = _compiled(command, sources)
        else:
            caution(
                f"there is no compiler {shown(compiler)}, so that {target.name} has sources alone, which not every tool compiles: install"
                " one, or give another command as compiler"
            )
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, each in content.items():
            packed.writestr(zipfile.ZipInfo(name, STAMP), each, zipfile.ZIP_DEFLATED)
    return files.write(target, archive.getvalue())


def _command(compiler: str | None) -> list[str]:
    """The words of a compiler's command."""
    try:
        return [] if compiler is None else shlex.split(compiler)
    except (ValueError, AttributeError) as error:  # quotation marks that do not end; no text
        raise PinpressError(f"compiler is {shown(compiler)}: give a command, such as 'cc', or None ({error})") from None


def _compiled(command: Sequence[str], sources: dict[str, str]) -> bytes:
    """The shared library of the sources; raises `PinpressError` with what the compiler says."""
    with tempfile.TemporaryDirectory(prefix="pinpress-") as folder:
        for name, text in sources.items():
            Path(folder, name).write_text(text, encoding="utf-8")
        inputs, made = [name for name in sources if name.endswith(".c")], Path(folder, "library")
        # -O3: without it loops over the table use no vectors; not -march, as the FMU goes to other machines
        options = ["-std=c99", "-O3", "-shared", *([] if os.name == "nt" else ["-fPIC"]), *inputs, "-o", made.name, "-lm"]
        done = subprocess.run([*command, *options], cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode or not made.exists():
            raise PinpressError(f"{command[0]} could not compile the FMU: {done.stderr.strip()[:500]}; give another compiler, or None")
        return made.read_bytes()


# ----------------------------------------------------------------------------------------------------------------- modelDescription.xml


def _values(table: PressTable, outputs: Sequence[str]) -> list[Value]:
    """All variables, in the order of their references from 0."""
    coordinate, count = table.coordinate, len(table.inputs)
    unit, effort = coordinate.unit, coordinate.effort_unit
    torque = "torque" if coordinate.turns else "driving_force"
    states, efforts = (1, 3), (5, *range(6, 6 + count))
    exact = {"variability": "continuous", "initial": "exact"}
    known = {"variability": "continuous"}
    found = [
        Value("angle" if coordinate.turns else "position", unit, "output", exact, {}, (1,)),
        Value("der_angle" if coordinate.turns else "der_position", f"{unit}/s", "local", known, {"derivative": "1"}, (3,)),
        Value("speed", f"{unit}/s", "output", exact, {"start": "0.0"}, (3,)),
        Value("acceleration", f"{unit}/s2", "output", known, {"derivative": "3"}, (*states, *efforts)),
        Value(torque, effort, "input", known, {"start": "0.0"}),
        *(Value(name, "", "input", known, {"start": "0.0"}) for name in table.inputs),
        Value("added_inertia", "kg m2" if coordinate.turns else "kg", "parameter", {"variability": "fixed"}, {"start": "0.0", "min": "0"}),
        Value("tolerance", "", "parameter", {"variability": "tunable"}, {"start": repr(TOLERANCE), "min": "1e-14", "max": "0.01"}),
    ]
    units = {part: each.unit for each in table.quantities for part in each.components}
    for name, component in zip(outputs, table.components, strict=True):
        terms = np.asarray(np.any(table.term_of(component), axis=(0, 2)))
        needs = {1} | ({3} if terms[[SQUARE, SPEED]].any() else set()) | {6 + k for k in range(count) if terms[FORCES + k]}
        needs |= {*states, *efforts} if terms[ACCELERATION] else set()
        found.append(Value(name, units[component], "output", known, {}, tuple(sorted(needs))))
    # an input may be called as the torque is
    return [each._replace(name=name) for each, name in zip(found, identifiers(each.name for each in found), strict=True)]


def _description(table: PressTable, identifier: str, guid: str, values: Sequence[Value], start: float) -> bytes:
    """modelDescription.xml."""
    generator = next((words for name, words in table.origin if name == "computed by"), "pinpress")
    root = ElementTree.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=table.press_name,
        guid=guid,
        description=" ".join(header_lines(table)),
        generationTool=generator.partition(",")[0],
        numberOfEventIndicators="0",
    )
    for kind in ("ModelExchange", "CoSimulation"):
        options = {"modelIdentifier": identifier, "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true"}
        if kind == "CoSimulation":
            options["canHandleVariableCommunicationStepSize"] = "true"
        sources = ElementTree.SubElement(ElementTree.SubElement(root, kind, options), "SourceFiles")
        for name in ("fmu.c", f"{STEM}.c"):
            ElementTree.SubElement(sources, "File", name=name)
    units = ElementTree.SubElement(root, "UnitDefinitions")
    for name in sorted({each.unit for each in values} - {""}):
        powers = {part: str(power) for part, power in UNITS[name].items()}
        ElementTree.SubElement(ElementTree.SubElement(units, "Unit", name=name), "BaseUnit", powers)
    categories = ElementTree.SubElement(root, "LogCategories")
    ElementTree.SubElement(categories, "Category", name="logStatusError")
    variables = ElementTree.SubElement(root, "ModelVariables")
    for reference, each in enumerate(values):
        about = {"name": each.name, "valueReference": str(reference), "causality": each.causality, **each.attributes}
        real = {"unit": each.unit} if each.unit else {}
        real |= each.real | ({"start": repr(start)} if reference == 0 else {})
        ElementTree.SubElement(ElementTree.SubElement(variables, "ScalarVariable", about), "Real", real)
    structure = ElementTree.SubElement(root, "ModelStructure")
    numbered = list(enumerate(values, 1))
    calculated = [(k, each) for k, each in numbered if each.dependencies is not None and "initial" not in each.attributes]
    parts = {
        "Outputs": [(k, each) for k, each in numbered if each.causality == "output"],
        "Derivatives": [(k, each) for k, each in numbered if "derivative" in each.real],
        "InitialUnknowns": calculated,
    }
    inertia = next(k for k, each in numbered if each.causality == "parameter")  # the tolerance comes behind it
    for title, unknowns in parts.items():
        part = ElementTree.SubElement(structure, title)
        for k, each in unknowns:
            needs = list(each.dependencies or ())
            if title == "InitialUnknowns" and 5 in needs:  # what depends on the torque depends on the inertia that it accelerates
                needs.append(inertia)
            ElementTree.SubElement(part, "Unknown", index=str(k), dependencies=" ".join(map(str, sorted(needs))))
    ElementTree.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ElementTree.tostring(root, encoding="unicode")}\n'.encode()
