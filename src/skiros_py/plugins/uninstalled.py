"""A package as if it were installed, with the entry points that its ``pyproject.toml`` has now.

The metadata of an installed package have the entry points of the time of its installation; while it is being written
that is too late.
"""

from __future__ import annotations

import importlib
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any


@contextmanager
def as_if_installed(project: Mapping[str, Any], source: Path) -> Iterator[None]:
    """Makes a package known to this process, whether it is installed or not.

    Modules of it that are imported meanwhile are forgotten at the end: the next time they may be written differently.

    Args:
        project: The table ``[project]`` of its ``pyproject.toml``.
        source: The folder that its Python package is in.
    """
    before, loaded = list(sys.path), set(sys.modules)
    with tempfile.TemporaryDirectory(prefix="skiros-installed-") as site:
        _write_metadata(Path(site), project)
        sys.path[:0] = [site, str(source)]
        importlib.invalidate_caches()
        try:
            yield
        finally:
            sys.path[:] = before
            own = {path.stem for path in source.iterdir()}
            for name in [name for name in sys.modules if name.partition(".")[0] in own and name not in loaded]:
                del sys.modules[name]
            importlib.invalidate_caches()


def _write_metadata(site: Path, project: Mapping[str, Any]) -> None:
    """Writes what an installer would leave behind; of two of one name the one that is found first counts."""
    name, version = str(project["name"]), str(project.get("version", "0"))
    info = site / f"{name.replace('-', '_')}-{version}.dist-info"
    info.mkdir()
    needs = "".join(f"Requires-Dist: {requirement}\n" for requirement in project.get("dependencies", ()))
    head = f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n"
    (info / "METADATA").write_text(head + needs, encoding="utf-8")
    groups = project.get("entry-points", {}).items()
    lines = (line for group, own in groups for line in (f"[{group}]", *(f"{k} = {v}" for k, v in own.items())))
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
