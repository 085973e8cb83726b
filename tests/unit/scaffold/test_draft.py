"""Files are written all or none."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.errors import FileError, UsageError
from skiros_py.scaffold.draft import Draft, check_names


def files(folder: Path) -> dict[str, str]:
    return {str(f.relative_to(folder)): f.read_text(encoding="utf-8") for f in folder.rglob("*") if f.is_file()}


def test_new_files_are_written_and_others_changed(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("old", encoding="utf-8")

    Draft(tmp_path, {"b/c": "new"}, {"a": "changed"}).write()

    assert files(tmp_path) == {"a": "changed", "b/c": "new"}


def test_if_one_file_exists_already_no_file_is_written(tmp_path: Path) -> None:
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "c").write_text("mine", encoding="utf-8")

    with pytest.raises(UsageError, match="b/c: there already"):
        Draft(tmp_path, {"a": "new", "b/c": "new"}).write()

    assert files(tmp_path) == {"b/c": "mine"}


def test_if_the_last_file_cannot_be_written_the_first_ones_are_removed(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine", encoding="utf-8")

    with pytest.raises(FileError, match="nothing was changed"):
        Draft(tmp_path, {"deep/er/a": "new"}, {"nowhere/b": "changed"}).write()
    with pytest.raises(UsageError, match="cannot be written"):
        Draft(tmp_path, {"deep/a": "new", "file/b": "new"}).write()

    assert files(tmp_path) == {"file": "mine"}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file"]


def test_a_new_folder_appears_complete_and_never_replaces_another(tmp_path: Path) -> None:
    draft = Draft(tmp_path / "deep" / "pack", {"src/a": "a", "b": "b"})

    draft.write()

    assert files(tmp_path) == {"deep/pack/src/a": "a", "deep/pack/b": "b"}
    with pytest.raises(UsageError, match="there already"):
        draft.write()


def test_a_folder_that_cannot_be_written_leaves_nothing_behind(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="cannot be written"):
        Draft(tmp_path / "pack", {"a": "", "a/b": ""}).write()

    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "code",
    [
        "from a import SCAN\n\nSCAN = 1\n",
        "from a import P\nfrom b import P\n",
        "from a import Success\n\n\nclass Success:\n    pass\n",
    ],
)
def test_two_definitions_with_one_name_in_a_file_are_refused(code: str) -> None:
    with pytest.raises(UsageError, match=r"skills/scan\.py would have two things called \w+; choose another name"):
        check_names("skills/scan.py", code)


def test_a_name_that_is_used_twice_is_defined_once() -> None:
    check_names("scan.py", "from a import P, Do\n\nSCAN = Do(P)\nOTHER = Do(P)\n")
