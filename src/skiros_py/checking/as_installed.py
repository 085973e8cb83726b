"""Checks a package in a folder without installing it."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from skiros_py.errors import FileError
from skiros_py.plugins import as_if_installed


@contextmanager
def as_installed(path: Path) -> Iterator[str]:
    """Registers the package in a folder as if it were installed; yields its name.

    Raises:
        FileError: The folder has no ``pyproject.toml`` that describes a package with plug-ins.
    """
    project = _project(path)
    source = path / "src" if (path / "src").is_dir() else path
    with as_if_installed(project, source.resolve()):
        yield str(project["name"])


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
