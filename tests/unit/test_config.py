from __future__ import annotations

import os
from pathlib import Path

import pytest

from skiros_py.config import find_scene, named_scene, ontology_paths, scene_names
from skiros_py.errors import FileError, UnknownName, UsageError


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

    with pytest.raises(FileError, match=r"folder\.ttl: the scene file is a folder, not a file"):
        find_scene(str(tmp_path / "folder.ttl"))


def test_ontologies_of_the_environment_come_after_the_shipped_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = ontology_paths()
    monkeypatch.setenv("SKIROS_ONTOLOGIES", f"{tmp_path}::")

    assert ontology_paths() == (*before, tmp_path)


@pytest.mark.parametrize("suffix", [".ttl", ".owl", ".rdf", ".owx", ".xml"])
def test_a_scene_may_be_in_any_language_that_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    (tmp_path / f"mine{suffix}").touch()
    monkeypatch.setenv("SKIROS_SCENES", str(tmp_path))

    assert find_scene("mine") == tmp_path / f"mine{suffix}"
    assert find_scene(str(tmp_path / f"mine{suffix}")) == tmp_path / f"mine{suffix}"
    assert "mine" in scene_names()


NO_NAMES = [
    "../kitting",
    "/etc/passwd",
    "kitting/",
    "",
    ".",
    "a b",
    "-x",
    "kitting\0",
    "kitting\n",
    "x" * 65,
    "x" * 300,
    "größe",
]


@pytest.mark.parametrize("name", NO_NAMES)
def test_what_is_no_name_is_never_looked_for_in_any_folder(name: str) -> None:
    with pytest.raises(UsageError, match=r"is no name of a scene.*must end in \.ttl") as caught:
        find_scene(name)

    assert len(str(caught.value)) < 400


@pytest.mark.parametrize("name", ["../kitting.ttl", "kitting.ttl", "/kitting.ttl"])
def test_a_path_is_no_name(name: str) -> None:
    with pytest.raises(UsageError, match="is no name of a scene"):
        named_scene(name)


@pytest.mark.parametrize("path", ["nul\0.ttl", "line\n.ttl"])
def test_a_path_has_characters_that_can_be_printed(path: str) -> None:
    with pytest.raises(UsageError, match="cannot be printed"):
        find_scene(path)


def test_a_path_that_is_too_long_for_any_file_is_told_in_short(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="does not exist") as caught:
        find_scene(f"{tmp_path}/{'x' * 5000}.ttl")

    assert len(str(caught.value)) < 500


def test_a_link_out_of_the_scene_folder_is_no_scene_of_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "scenes"
    folder.mkdir()
    (tmp_path / "secret.ttl").touch()
    (folder / "mine.ttl").touch()
    (folder / "outside.ttl").symlink_to(tmp_path / "secret.ttl")
    (folder / "inside.ttl").symlink_to("mine.ttl")
    (folder / "circle.ttl").symlink_to("circle.ttl")
    (folder / "dangling.ttl").symlink_to("nowhere.ttl")
    (folder / "folder.ttl").mkdir()
    monkeypatch.setenv("SKIROS_SCENES", str(folder))

    assert find_scene("inside") == folder / "inside.ttl"
    assert not {"outside", "circle", "dangling", "folder"} & set(scene_names())
    with pytest.raises(FileError, match="symbolic link out of"):
        find_scene("outside")


def test_what_is_no_file_is_called_what_it_is(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.ttl")
    (tmp_path / "device.ttl").symlink_to("/dev/zero")
    (tmp_path / "circle.ttl").symlink_to("circle.ttl")
    (tmp_path / "dangling.ttl").symlink_to("nowhere.ttl")

    for name, what in (
        ("pipe", "is a pipe, not a file"),
        ("device", "is a device, not a file"),
        ("circle", "is a link that leads round in circles"),
        ("dangling", "is a link to a file that does not exist"),
        ("nothing", "does not exist"),
    ):
        with pytest.raises(FileError, match=f"the scene file {what}"):
            find_scene(str(tmp_path / f"{name}.ttl"))
