"""The folder with the replays stays small."""

from __future__ import annotations

from pathlib import Path

from skiros_py.server.replays.shelf import ReplayShelf


def filled(shelf: ReplayShelf, count: int) -> ReplayShelf:
    shelf.prepare()
    for number in range(1, count + 1):
        shelf.path(number).write_bytes(bytes(100))
    return shelf


def kept(folder: Path) -> list[int]:
    return sorted(int(file.stem) for file in folder.iterdir())


def test_of_too_many_the_oldest_go(tmp_path: Path) -> None:
    filled(ReplayShelf(tmp_path / "replays", most=3), 12).make_room(())
    assert kept(tmp_path / "replays") == [10, 11, 12]


def test_of_too_large_ones_the_oldest_go(tmp_path: Path) -> None:
    filled(ReplayShelf(tmp_path / "replays", room=450), 12).make_room(())
    assert kept(tmp_path / "replays") == [9, 10, 11, 12]


def test_what_is_being_written_stays(tmp_path: Path) -> None:
    filled(ReplayShelf(tmp_path / "replays", most=2), 5).make_room({1})
    assert kept(tmp_path / "replays") == [1, 5]


def test_what_is_not_there_can_be_removed(tmp_path: Path) -> None:
    ReplayShelf(tmp_path / "replays").remove(7)
    assert not (tmp_path / "replays").exists()
