"""A package as pip would install it, without changing the environment."""

from __future__ import annotations

import tomllib
from pathlib import Path


def install(package: Path, site: Path) -> None:
    """Leaves behind what pip would for the entry points of a package."""
    project = tomllib.loads((package / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    info = site / f"{package.name}-{project['version']}.dist-info"
    info.mkdir(parents=True)
    needs = "".join(f"Requires-Dist: {need}\n" for need in project["dependencies"])
    head = f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n{needs}"
    (info / "METADATA").write_text(head, encoding="utf-8")
    groups = (
        f"[{g}]\n" + "".join(f"{k} = {v}\n" for k, v in own.items()) for g, own in project["entry-points"].items()
    )
    (info / "entry_points.txt").write_text("\n".join(groups), encoding="utf-8")
