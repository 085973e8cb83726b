"""What all tests share.

Numerics run on one thread, as in the worker processes: results do not depend on the number of cores. That is set before
any test module loads a numerical library, which read it once.
"""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))


class Site:
    """A folder on Python's path with distributions as pip would leave them behind."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def install(
        self,
        name: str,
        groups: Mapping[str, Mapping[str, str]],
        files: Mapping[str, str] | None = None,
        *,
        version: str = "0.3",
        requires: Sequence[str] = (),
    ) -> Path:
        """Installs a distribution.

        Args:
            name: Its name.
            groups: Entry points by group, without "skiros.".
            files: Text by path: its modules and data.
            version: Its version.
            requires: What it requires.

        Returns:
            The folder of its metadata.
        """
        info = self.folder / f"{name.replace('-', '_')}-{version}.dist-info"
        info.mkdir()
        head = f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n"
        (info / "METADATA").write_text(head + "".join(f"Requires-Dist: {r}\n" for r in requires), encoding="utf-8")
        points = (f"[skiros.{g}]\n" + "".join(f"{n} = {v}\n" for n, v in own.items()) for g, own in groups.items())
        (info / "entry_points.txt").write_text("".join(points), encoding="utf-8")
        for file, text in (files or {}).items():
            path = self.folder / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        return info


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Site:
    """An empty folder on Python's path in which distributions can be installed."""
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(str(folder))
    return Site(folder)
