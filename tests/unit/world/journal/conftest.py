"""A data directory with the tiny scene."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from skiros_py.testing import tiny_ontology, tiny_scene
from skiros_py.world.journal.data_directory import DataDirectory
from skiros_py.world.world import World

Open = Callable[[], DataDirectory]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "data"


@pytest.fixture
def open_tiny(tmp_path: Path, folder: Path) -> Iterator[Open]:
    """Opens the directory, with the tiny scene as first content; closes what the test left open."""
    scene = tiny_scene(tmp_path, goals=("In(ball_1, slot_1)",))
    with ExitStack() as stack:
        yield lambda: stack.enter_context(DataDirectory.open(folder, tiny_ontology(), scene=scene))


@pytest.fixture
def weigh() -> Callable[..., None]:
    def write(world: World, mass: float, element: str = "ball_1") -> None:
        with world.transaction("weigh", f"{mass} kg") as tx:
            tx.set(element, "sk:mass", mass)

    return write
