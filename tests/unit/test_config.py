from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.config import find_scene, ontology_paths, scene_names
from skiros_py.errors import FileError, UnknownName


def test_a_scene_is_found_by_name_in_the_folders_of_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mine.ttl").touch()
    monkeypatch.setenv("SKIROS_SCENES", f"{tmp_path}:/nowhere")

    assert find_scene("mine") == tmp_path / "mine.ttl"
    assert "mine" in scene_names()


def test_ones_own_scene_comes_before_a_shipped_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "kitting.ttl").touch()
    monkeypatch.setenv("SKIROS_SCENES", str(tmp_path))

    assert find_scene("kitting") == tmp_path / "kitting.ttl"
    assert scene_names().count("kitting") == 1


def test_a_scene_is_found_by_path(tmp_path: Path) -> None:
    file = tmp_path / "mine.ttl"
    file.touch()

    assert find_scene(str(file)) == file


def test_an_unknown_scene_is_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownName) as caught:
        find_scene("kiting")

    assert caught.value.nearest == "kitting"


def test_a_scene_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"kiting\.ttl: the scene file does not exist"):
        find_scene(str(tmp_path / "kiting.ttl"))


def test_a_folder_is_no_scene_file(tmp_path: Path) -> None:
    (tmp_path / "folder.ttl").mkdir()

    with pytest.raises(FileError, match=r"folder\.ttl: the scene file is a folder"):
        find_scene(str(tmp_path / "folder.ttl"))


def test_ontologies_of_the_environment_come_after_the_shipped_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = ontology_paths()
    monkeypatch.setenv("SKIROS_ONTOLOGIES", f"{tmp_path}::")

    assert ontology_paths() == (*before, tmp_path)
