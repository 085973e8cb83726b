"""URDF files that name meshes of installed packages: they are found when the file is read, wherever Python has them."""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ET
from pathlib import Path

from skiros_py.errors import FileError

INSTALLED = "installed:"
"""What a mesh begins with whose path is below a folder in which Python looks for packages."""


def installed_name(file: Path) -> str | None:
    """Returns the name under which a file of an installed package is found again; None for a file of none."""
    for folder in _folders():
        if file.is_relative_to(folder) and folder.name in ("site-packages", "dist-packages"):
            return INSTALLED + file.relative_to(folder).as_posix()
    return None


def with_meshes(urdf: Path) -> str:
    """Returns the text of a URDF file in which all meshes have absolute paths.

    Raises:
        FileError: It cannot be read, or a mesh is not there.
    """
    try:
        robot = ET.parse(urdf).getroot()  # noqa: S314 - a file of an installed package
    except (OSError, ET.ParseError) as error:
        raise FileError(urdf, f"no URDF: {error}") from error
    for mesh in robot.iter("mesh"):
        name = mesh.get("filename", "")
        within = name.removeprefix(INSTALLED)
        places = [urdf.parent / name] if within == name else [folder / within for folder in _folders()]
        found = next((place for place in places if place.is_file()), None)
        if found is None:
            raise FileError(urdf, f"the mesh {within} is not there: install the package that it comes with")
        mesh.set("filename", str(found))
    return ET.tostring(robot, encoding="unicode", xml_declaration=True)


def _folders() -> list[Path]:
    return [Path(folder) for folder in dict.fromkeys(sys.path) if folder]
