"""Data directories know which scene, and which version of its file, was loaded into them."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.config import find_scene
from skiros_py.station.worlds import LoadedScene, open_data, present_scene, remember_scene, why_not_loaded
from skiros_py.world.change import Writer


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    file = tmp_path / "mine.ttl"
    file.write_text(find_scene("kitting").read_text())
    return file


def reason(data: Path, scene: Path) -> str:
    with open_data(data, str(scene)) as directory:
        return why_not_loaded(data, directory.world, str(scene))


def test_the_scene_that_a_directory_was_made_from_counts_as_loaded(tmp_path: Path, scene: Path) -> None:
    assert reason(tmp_path / "data", scene) == ""
    assert reason(tmp_path / "data", scene) == ""


def test_a_scene_whose_file_was_changed_since_is_said_to_be_an_earlier_version(tmp_path: Path, scene: Path) -> None:
    reason(tmp_path / "data", scene)
    scene.write_text(scene.read_text() + "\n# edited\n")

    assert "an earlier version of" in reason(tmp_path / "data", scene)


def test_another_scene_is_said_not_to_be_loaded(tmp_path: Path, scene: Path) -> None:
    reason(tmp_path / "data", scene)

    assert "lives mine: kitting_two was not loaded" in reason(tmp_path / "data", Path("kitting_two"))


def test_an_undone_load_leaves_the_scene_before(tmp_path: Path, scene: Path) -> None:
    data = tmp_path / "data"
    with open_data(data, str(scene)) as directory:
        world = directory.world
        with world.transaction("ann", "loads", writer=Writer.PERSON) as tx:
            tx.set("starter_1", "sk:mass", 0.7)
        assert tx.change is not None
        remember_scene(data, LoadedScene("second", tx.change.number, 1))
        assert present_scene(data, world).name == "second"
        with world.transaction("ann", "undoes", writer=Writer.PERSON, undoes=tx.change.number) as tx:
            tx.set("starter_1", "sk:mass", None)

        assert present_scene(data, world).name == "mine"


def test_a_damaged_list_of_loaded_scenes_is_reported_and_read_as_empty(
    tmp_path: Path, scene: Path, caplog: pytest.LogCaptureFixture
) -> None:
    data = tmp_path / "data"
    reason(data, scene)
    (data / "scenes.json").write_text("[")

    assert "another one, of no name" in reason(data, scene)
    assert "are not known" in caplog.text
