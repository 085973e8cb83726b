"""Saving scenes: what was not seen is not overwritten."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from skiros_py.errors import StaleVersion
from skiros_py.station.requests import Seen
from skiros_py.station.scenes.service import SceneService


class Changing:
    """A saved scene of which another thread saves version 2 as soon as somebody has looked at version 1."""

    name, saved = "shared", True

    def __init__(self) -> None:
        self._versions = [1]

    @property
    def version(self) -> int:
        self._versions.append(2)
        return self._versions.pop(0)


class Store:
    """Refuses every save, and keeps which version was expected."""

    def __init__(self) -> None:
        self.expected: list[int | None] = []

    def find(self, _name: str) -> Changing:
        return Changing()

    def save(self, _name: str, _scene: object, *, expects: int | None) -> None:
        self.expected.append(expects)
        raise StaleVersion("it is another version")


def test_a_save_that_comes_between_the_check_and_the_writing_is_not_overwritten() -> None:
    store = Store()
    world = SimpleNamespace(snapshot=object)
    station: Any = SimpleNamespace(scene_store=store, session=SimpleNamespace(world=world))

    with pytest.raises(StaleVersion):
        SceneService(station).save("shared", Seen(1))

    assert store.expected == [1]
