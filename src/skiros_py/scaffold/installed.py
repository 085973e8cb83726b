"""A package as if it were installed, with the entry points that its ``pyproject.toml`` has now.

An installed package tells the entry points it had when it was installed; while it is being written that is too late.
"""

from __future__ import annotations

import importlib
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from skiros_py.scaffold.project import Project


@contextmanager
def as_installed(folder: Path) -> Iterator[Project]:
    """Makes a package known to this process by what its ``pyproject.toml`` says; installed or not.

    Args:
        folder: The package's folder, in which ``pyproject.toml`` lies, or one below it.

    Raises:
        UsageError: There is no package for skiros-py.
    """
    project = Project.around(folder)
    before, loaded = list(sys.path), set(sys.modules)
    with tempfile.TemporaryDirectory(prefix="skiros-installed-") as site:
        _write_metadata(Path(site), project)
        sys.path[:0] = [site, str(project.source)]
        importlib.invalidate_caches()
        try:
            yield project
        finally:
            sys.path[:] = before
            _forget(project.package, loaded)
            importlib.invalidate_caches()


def _write_metadata(site: Path, project: Project) -> None:
    """Writes what an installer would leave behind; of two of one name the one that is found first counts."""
    info = site / f"{project.name.replace('-', '_')}-{project.version}.dist-info"
    info.mkdir()
    needs = "".join(f"Requires-Dist: {requirement}\n" for requirement in project.dependencies)
    head = f"Metadata-Version: 2.1\nName: {project.name}\nVersion: {project.version}\n"
    (info / "METADATA").write_text(head + needs, encoding="utf-8")
    (info / "entry_points.txt").write_text(_entry_points(project.entry_points), encoding="utf-8")


def _entry_points(groups: Mapping[str, Mapping[str, Any]]) -> str:
    lines = (line for group, own in groups.items() for line in (f"[{group}]", *(f"{k} = {v}" for k, v in own.items())))
    return "\n".join(lines) + "\n"


def _forget(package: str, loaded: set[str]) -> None:
    """Forgets modules of the package that were not there before: the next one may be written differently."""
    for name in [name for name in sys.modules if name.partition(".")[0] == package and name not in loaded]:
        del sys.modules[name]
