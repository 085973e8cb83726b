"""Files to be written: all of them, or none."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from skiros_py.errors import UsageError
from skiros_py.world.scene.atomic import write_atomically


@dataclass(frozen=True, slots=True)
class Draft:
    """The files to be written below one folder.

    Attributes:
        root: The folder.
        new: Text of new files, by path below it.
        changed: Text of existing files, by path.
        notes: Notes for the author.
    """

    root: Path
    new: Mapping[str, str] = field(default_factory=dict)
    changed: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def check(self) -> None:
        """Checks that everything can be written.

        Raises:
            UsageError: A file already exists, or there is no folder to write to.
        """
        there = [path for path in self.new if _is_there(self.root / path)]
        if there:
            raise UsageError(f"{', '.join(there)}: there already below {self.root}, and nothing is overwritten")

    def write(self) -> None:
        """Writes the new files first, so that changed files never refer to missing ones.

        Raises:
            UsageError: A file already exists, or cannot be written; nothing was changed.
            FileError: An existing file cannot be changed; nothing was changed.
        """
        self.check()
        written: list[Path] = []
        try:
            for path, text in self.new.items():
                _write_new(self.root / path, text, written)
            for path, text in self.changed.items():
                write_atomically(self.root / path, text)
        except BaseException as error:
            _undo(written)
            if isinstance(error, OSError):
                raise UsageError(f"{error.filename}: cannot be written ({error.strerror}); nothing was") from error
            raise

    def write_folder(self) -> None:
        """Writes a new folder: into a temporary one beside it, which is then renamed.

        Raises:
            UsageError: It already exists, or cannot be written.
        """
        if _is_there(self.root):
            raise UsageError(f"{self.root} is there already, and nothing is overwritten")
        try:
            self.root.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(prefix=".skiros-new-", dir=self.root.parent) as folder:
                inner = Path(folder) / self.root.name
                for path, text in self.new.items():
                    _write_new(inner / path, text, [])
                inner.rename(self.root)
        except OSError as error:
            raise UsageError(f"{error.filename}: cannot be written ({error.strerror}); nothing was") from error


def _is_there(path: Path) -> bool:
    return path.exists() or path.is_symlink()


def _write_new(path: Path, text: str, written: list[Path]) -> None:
    for folder in reversed([f for f in path.parents if not f.exists()]):
        folder.mkdir()
        written.append(folder)
    with path.open("x", encoding="utf-8") as file:
        written.append(path)
        file.write(text)


def _undo(written: list[Path]) -> None:
    for path in reversed(written):
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)
