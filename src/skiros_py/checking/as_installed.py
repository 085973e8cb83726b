"""Makes a package that lies in a folder known as if it were installed, for a while."""

from __future__ import annotations

import sys
import tempfile
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from skiros_py.errors import FileError


@contextmanager
def as_installed(path: Path) -> Iterator[str]:
    """Puts a package on Python's path, with metadata made from its ``pyproject.toml``; yields its name.

    Raises:
        FileError: The folder has no ``pyproject.toml`` that describes a package with plug-ins.
    """
    project = _project(path)
    name = str(project["name"])
    with tempfile.TemporaryDirectory(prefix="skiros-check-") as folder:
        _write_metadata(Path(folder), project)
        added = [folder, str(_sources(path))]
        sys.path[:0] = added
        try:
            yield name
        finally:
            for entry in added:
                sys.path.remove(entry)


def _project(path: Path) -> Mapping[str, Any]:
    file = path / "pyproject.toml"
    try:
        project: dict[str, Any] = tomllib.loads(file.read_text(encoding="utf-8")).get("project", {})
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise FileError(file, f"cannot be read: {reason}; give the folder of a package") from error
    except tomllib.TOMLDecodeError as error:
        raise FileError(file, f"is no TOML: {error}") from error
    points = project.get("entry-points", {})
    if "name" not in project or not any(group.startswith("skiros.") for group in points):
        raise FileError(file, "names no plug-ins: it needs a name and entry points such as 'skiros.skills'")
    return project


def _sources(path: Path) -> Path:
    """Returns the folder that packages lie in: ``src``, where there is one."""
    return (path / "src" if (path / "src").is_dir() else path).resolve()


def _write_metadata(folder: Path, project: Mapping[str, Any]) -> None:
    name, version = str(project["name"]).replace("-", "_"), str(project.get("version", "0"))
    info = folder / f"{name}-{version}.dist-info"
    info.mkdir()
    requires = "".join(f"Requires-Dist: {one}\n" for one in project.get("dependencies", ()))
    head = f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {version}\n{requires}"
    (info / "METADATA").write_text(head, encoding="utf-8")
    lines = [
        line
        for group, points in project["entry-points"].items()
        for line in (f"[{group}]", *(f"{key} = {value}" for key, value in points.items()))
    ]
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
