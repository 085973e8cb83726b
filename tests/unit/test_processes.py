"""What another Python process is given, it can read."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from skiros_py.errors import SkirosError
from skiros_py.processes import packed

READ = "import pickle, sys; thing = pickle.load(sys.stdin.buffer); print(thing() if callable(thing) else thing)"


@dataclass(frozen=True)
class Here:
    """Of a module that a new process does not find."""

    number: int

    def __call__(self) -> int:
        return self.number + 1


@dataclass(frozen=True, slots=True)
class One:
    """One field."""

    number: int

    def __call__(self) -> object:
        return self.number


@dataclass(frozen=True, slots=True)
class Two(One):
    """A field more, and another in it."""

    inner: One

    def __call__(self) -> object:
        return self.number, self.inner()


class Own(One):
    """It says itself what its state is; no dataclass itself, as Python 3.11 before 3.11.3 replaces what one says."""

    __slots__ = ()

    def __getstate__(self) -> int:
        return self.number * 10

    def __setstate__(self, state: int) -> None:
        object.__setattr__(self, "number", state)


def read_elsewhere(data: bytes, folder: Path) -> str:
    done = subprocess.run([sys.executable, "-c", READ], input=data, capture_output=True, check=True, cwd=folder)
    return done.stdout.decode().strip()


def test_an_object_of_a_test_or_script_is_read_by_a_process_that_cannot_import_it(tmp_path: Path) -> None:
    assert read_elsewhere(packed(Here(4)), tmp_path) == "5"


@pytest.mark.parametrize(("thing", "read"), [(One(1), "1"), (Two(2, One(3)), "(2, 3)"), (Own(4), "40")])
def test_dataclasses_with_slots_keep_their_fields(thing: object, read: str, tmp_path: Path) -> None:
    assert read_elsewhere(packed(thing), tmp_path) == read


def test_a_function_made_in_memory_is_read(tmp_path: Path) -> None:
    wanted = 3

    assert read_elsewhere(packed(lambda: wanted * 2), tmp_path) == "6"


@pytest.mark.parametrize("thing", [SkirosError, pytest.approx, len, Path], ids=lambda thing: thing.__name__)
def test_what_can_be_imported_is_named_not_copied(thing: object) -> None:
    assert len(packed(thing)) < 120
