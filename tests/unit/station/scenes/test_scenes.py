"""Saved scenes are overwritten and removed only by callers who have seen the current version."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.errors import Refused, StaleVersion
from skiros_py.station.requests import ANY_VERSION, Seen
from skiros_py.station.scenes.scenes import SceneStore
from skiros_py.testing.tiny import tiny_world


def test_a_scene_that_was_saved_meanwhile_is_neither_overwritten_nor_removed(tmp_path: Path) -> None:
    store, world = SceneStore(tmp_path / "scenes"), tiny_world()
    first = store.save("shared", world.snapshot()).version
    with world.transaction("anna", "another goal") as tx:
        tx.set_goals(("LocationEmpty(box_a)",))
    second = store.save("shared", world.snapshot(), Seen(first)).version

    with pytest.raises(Refused, match="say which version you have seen"):
        store.save("shared", world.snapshot())
    for change in (
        lambda seen: store.save("shared", world.snapshot(), seen),
        lambda seen: store.remove("shared", seen),
    ):
        with pytest.raises(StaleVersion, match=f"version {first} is not the current one"):
            change(Seen(first))
    assert store.find("shared").version == second != first


def test_a_scene_that_was_removed_meanwhile_is_not_saved_again_by_its_old_version(tmp_path: Path) -> None:
    store, world = SceneStore(tmp_path / "scenes"), tiny_world()
    version = store.save("shared", world.snapshot()).version
    store.remove("shared", ANY_VERSION)

    with pytest.raises(StaleVersion, match="it was removed since"):
        store.save("shared", world.snapshot(), Seen(version))
