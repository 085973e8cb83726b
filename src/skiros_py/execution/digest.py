"""The digest of a run: the same seed gives the same one."""

from __future__ import annotations

import hashlib
import json
import threading

from skiros_py.world.change import Change

_SHOWN = 16


class RunDigest:
    """Hashes the states and changes of a run; any thread may add to it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._hash = hashlib.sha256()

    def begin(self, state: bytes) -> None:
        """Forgets everything, and begins with a state."""
        with self._lock:
            self._hash = hashlib.sha256(state)

    def add(self, state: bytes) -> None:
        """Takes in a state."""
        with self._lock:
            self._hash.update(state)

    def add_change(self, change: Change) -> None:
        """Takes in a change of the world; any thread may have written it."""
        self.add(json.dumps(change.as_json(), sort_keys=True).encode())

    def __str__(self) -> str:
        with self._lock:
            return self._hash.hexdigest()[:_SHOWN]
