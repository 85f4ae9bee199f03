"""Build the recipe and run its tests where conda-forge is out of reach: with packages of PyPI in place of those of conda-forge.

Python and every package that is installed where this runs become conda packages, by their names on conda-forge, in a channel on disk;
rattler-build takes from it what the recipe names. So the recipe's script, command, names, versions, licence and tests are tried. What
conda-forge's own packages lack, this does not tell. It runs on the Python that the recipe names, on Linux: `nox -s recipe`.
"""

import sys
import tempfile
from importlib import metadata
from pathlib import Path

from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from rattler_build import FileEntry, Package, Stage0Recipe, ToolConfiguration, VariantConfig, assemble_package

RECIPE = Path(__file__).with_name("recipe.yaml")
ON_CONDA_FORGE = {"pin": "pinocchio-python", "lazy-loader": "lazy_loader"}  # names that differ from those on PyPI
PLATFORM = "linux-64"


def main() -> None:
    """Print each package of the channel, what was built, and what its tests said.

    Raises:
        SystemExit: a test failed.
    """
    with tempfile.TemporaryDirectory() as folder:
        channel = Path(folder)
        put_python(channel)
        for found in metadata.distributions():
            if canonicalize_name(found.name) not in ("pinpress", "setuptools"):
                put_installed(channel, found)
        channels = [channel.as_uri()]
        variants = VariantConfig({"python_min": [f"{sys.version_info.major}.{sys.version_info.minor}"]})
        (built,) = Stage0Recipe.from_file(RECIPE).run_build(variants, ToolConfiguration(), output_dir=channel, channels=channels)
        package = Package.from_file(built.packages[0])
        print("", package.filename, *package.depends, sep="\n  ")
        results = package.run_tests(channel=channels)
        for result in results:
            print(f"\ntest {result.test_index} {'passed' if result.success else 'FAILED'}", *result.output, sep="\n  ")
        if not results or not all(result.success for result in results):
            raise SystemExit(1)


def put_python(channel: Path) -> None:
    """This interpreter without its packages."""
    home = Path(sys.base_prefix)
    files = [path for path in home.rglob("*") if path.is_file() and not {"site-packages", "__pycache__"} & set(path.parts)]
    put(channel, "python", ".".join(map(str, sys.version_info[:3])), home, files, [])


def put_installed(channel: Path, found: metadata.Distribution) -> None:
    """A package that is installed here, with what it requires on this machine."""
    home = Path(sys.prefix).resolve()
    files = [path for file in found.files or () if (path := Path(str(found.locate_file(file))).resolve()).is_file()]
    files = [path for path in files if path.is_relative_to(home) and path.suffix != ".pyc"]
    requirements = [Requirement(line) for line in found.requires or ()]
    here = default_environment() | {"extra": ""}
    needed = [f"{on_conda_forge(each.name)} {each.specifier}" for each in requirements if not each.marker or each.marker.evaluate(here)]
    put(channel, on_conda_forge(found.name), found.version, home, files, ["python", *needed])


def on_conda_forge(package: str) -> str:
    """The name there of a package of PyPI."""
    name = canonicalize_name(package)
    return ON_CONDA_FORGE.get(name, name)


def put(channel: Path, name: str, version: str, home: Path, files: list[Path], depends: list[str]) -> None:
    """Put a package of files, whose places in it are those below a folder, into the channel."""
    entries = [FileEntry.from_paths(path, path.relative_to(home)) for path in files]
    assemble_package(name, version, PLATFORM, "pypi_0", channel / PLATFORM, files=entries, depends=depends, compression_level=1)
    print(name, version, *depends)


if __name__ == "__main__":
    main()
