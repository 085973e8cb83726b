"""``skiros run --data`` keeps a record of each run, and ``skiros report`` tells of it."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest
from mcap.reader import make_reader
from support import warm_python


def skiros(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return warm_python.run([*warm_python.SKIROS, *arguments], cwd=folder)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a data directory in which two goals were pursued."""
    folder = tmp_path_factory.mktemp("work")
    for part in ("Starter", "Alternator"):
        run = skiros(folder, "run", "kitting", "--fake", "--data", "data", "--goal", f"InKit({part}, kit_1)")
        assert run.returncode == 0, run.stderr
        assert "recording  data/runs/" in run.stdout
    return folder


def test_each_run_has_its_recording_and_the_world_is_kept_between_runs(folder: Path) -> None:
    first, second = sorted((folder / "data" / "runs").iterdir())
    data = [json.loads(skiros(folder, "report", str(record), "--json").stdout) for record in (first, second)]

    assert [one["meta"]["scene"] for one in data] == ["kitting", "kitting"]
    assert [one["meta"]["goal"] for one in data] == [["InKit(Starter, kit_1)"], ["InKit(Alternator, kit_1)"]]
    assert all(one["complete"] and one["tasks"][0]["report"]["outcome"] == "reached" for one in data)
    assert data[1]["snapshots"]["last"] > 10.0
    assert data[1]["meta"]["version"] > data[0]["meta"]["version"]


def test_a_data_directory_gives_the_page_of_its_latest_run(folder: Path) -> None:
    made = skiros(folder, "report", "data", "--output", "page.html")
    page = (folder / "page.html").read_text()

    assert (made.returncode, made.stdout) == (0, "page.html\n")
    assert "InKit(Alternator, kit_1)" in page
    assert "InKit(Starter, kit_1)" not in page.split("Changes of the world")[0]


def test_a_report_page_is_written_to_the_current_folder_and_named_after_its_recording(folder: Path) -> None:
    record = min((folder / "data" / "runs").iterdir())
    made = skiros(folder, "report", str(record))

    assert made.stdout == f"{record.stem}.html\n"
    assert (folder / made.stdout.strip()).exists()


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("none.mcap", None, "there is no such recording"),
        ("text.txt", b"hello", "the file is damaged, or no recording of a run"),
        ("data/journal.db", None, "the file is damaged, or no recording of a run"),
        (".", None, "there is no recording of a run in it"),
    ],
)
def test_reporting_on_a_file_that_is_not_a_recording_ends_with_status_two_and_one_message(
    folder: Path, name: str, content: bytes | None, said: str
) -> None:
    if content is not None:
        (folder / name).write_bytes(content)
    result = skiros(folder, "report", name)

    assert result.returncode == 2
    assert said in result.stderr
    assert "Traceback" not in result.stderr


def test_a_truncated_recording_is_exported_with_an_index(folder: Path) -> None:
    first = min((folder / "data" / "runs").iterdir())
    (folder / "cut.mcap").write_bytes(first.read_bytes()[:-100])
    made = skiros(folder, "report", "cut.mcap", "--mcap", "whole.mcap")
    again = skiros(folder, "report", "cut.mcap", "--mcap", "whole.mcap")

    assert (made.returncode, made.stdout) == (0, "whole.mcap\n")
    with (folder / "whole.mcap").open("rb") as file, first.open("rb") as original:
        copy, whole = make_reader(file).get_summary(), make_reader(original).get_summary()
    assert copy is not None
    assert whole is not None
    assert copy.statistics is not None
    assert whole.statistics is not None
    assert copy.statistics.message_count == whole.statistics.message_count
    assert again.returncode == 2
    assert "there is a recording already" in again.stderr


def test_an_unwritable_report_page_is_reported(folder: Path) -> None:
    result = skiros(folder, "report", "data", "--output", "no/such/folder.html")

    assert result.returncode == 2
    assert "no/such/folder.html: cannot be written (No such file or directory)" in result.stderr


def test_a_run_reports_that_its_scene_file_was_changed_since_loading(tmp_path: Path) -> None:
    scene = tmp_path / "mine.ttl"
    skiros(tmp_path, "scene", "save", "kitting", "mine.ttl")
    run = ("run", "mine.ttl", "--fake", "--data", "data", "--goal", "EmptyHanded(gripper_1)")
    first = skiros(tmp_path, *run)
    scene.write_text(scene.read_text() + "\n# edited\n")

    second = skiros(tmp_path, *run)

    assert "earlier version" not in first.stderr
    assert "in data lives an earlier version of mine.ttl, whose file was changed since" in second.stderr


def test_pictures_of_a_recording_without_any_and_files_of_other_kinds_are_refused(folder: Path) -> None:
    none, other = (skiros(folder, "report", "data", "--pictures", name) for name in ("run.png", "run.jpg"))

    assert (none.returncode, other.returncode) == (2, 2)
    assert "there are no pictures in it" in none.stderr
    assert "use .png for a contact sheet, .gif or .webp for an animation" in other.stderr
    assert not (folder / "run.png").exists()
