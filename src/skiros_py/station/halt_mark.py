"""A requested stop, stored beside the world: it holds until a reset, even if the server ends."""

from __future__ import annotations

import json
import logging
import os
import threading
from pathlib import Path
from typing import NamedTuple

_log = logging.getLogger(__name__)


class Halt(NamedTuple):
    """A stop.

    Attributes:
        why: The reason, for a person.
        by: Name of the caller who requested it.
        since: Time of the stop [s since 1970].
    """

    why: str
    by: str
    since: float


class HaltMark:
    """The file whose presence keeps everything halted; thread-safe.

    Args:
        path: The file; it exists only while a requested stop holds.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._guard = threading.Lock()
        self._wanted: Halt | None = None

    def read(self) -> Halt | None:
        """Returns the stop left by a previous server; an unreadable file counts as a stop, too."""
        try:
            text = self._path.read_text(encoding="utf-8")
        except FileNotFoundError:
            return None
        except OSError as error:
            return Halt(f"whether somebody has stopped everything cannot be read: {error}", "", 0.0)
        try:
            why, by, since = json.loads(text)
            self._wanted = Halt(str(why), str(by), float(since))
        except (TypeError, ValueError):
            self._wanted = Halt("somebody has stopped everything before the server was restarted", "", 0.0)
        return self._wanted

    def keep(self, halt: Halt) -> None:
        """Writes a stop in a thread of its own: a stop does not wait for a disk."""
        self._wanted = halt
        try:
            threading.Thread(target=self._settle, name="skiros-halt-mark", daemon=True).start()
        except RuntimeError:  # no more threads: write in this one
            self._settle()

    def forget(self) -> None:
        """Removes the stop; quick if there is none."""
        if self._wanted is not None:
            self._wanted = None
            self._settle()

    def _settle(self) -> None:
        """Writes the present state to the file: a reset may have been requested before the stop was written."""
        with self._guard:
            wanted = self._wanted
            try:
                if wanted is None:
                    self._path.unlink(missing_ok=True)
                else:
                    self._write(json.dumps(wanted))
            except OSError as error:
                _log.error("a stop would not outlive the server: %s", error)

    def _write(self, text: str) -> None:
        new = self._path.with_name(f"{self._path.name}.new")
        with new.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        new.replace(self._path)
