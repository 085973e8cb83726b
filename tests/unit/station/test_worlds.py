"""Data directories know which scene, and which version of its file, was loaded into them."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from skiros_py.config import find_scene
from skiros_py.station.worlds import open_data, why_not_loaded
from skiros_py.world.change import SceneSource, Writer
from skiros_py.world.undo import undo


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    file = tmp_path / "mine.ttl"
    file.write_text(find_scene("kitting").read_text())
    return file


def reason(data: Path, scene: Path) -> str:
    with open_data(data, str(scene)) as directory:
        return why_not_loaded(data, directory.world, str(scene))


def test_a_directory_is_current_with_the_scene_it_was_created_from(tmp_path: Path, scene: Path) -> None:
    assert reason(tmp_path / "data", scene) == ""
    assert reason(tmp_path / "data", scene) == ""


def test_a_scene_file_changed_since_loading_is_reported_as_an_earlier_version(tmp_path: Path, scene: Path) -> None:
    reason(tmp_path / "data", scene)
    scene.write_text(scene.read_text() + "\n# edited\n")

    assert "an earlier version of" in reason(tmp_path / "data", scene)


def test_a_scene_that_differs_from_the_loaded_one_is_reported_as_not_loaded(tmp_path: Path, scene: Path) -> None:
    reason(tmp_path / "data", scene)

    assert "lives mine: kitting_two was not loaded" in reason(tmp_path / "data", Path("kitting_two"))


def test_an_undone_load_leaves_the_scene_before(tmp_path: Path, scene: Path) -> None:
    with open_data(tmp_path / "data", str(scene)) as directory:
        world = directory.world
        with world.transaction("ann", "loads", writer=Writer.PERSON) as tx:
            tx.set("starter_1", "sk:mass", 0.7)
            tx.set_source(SceneSource("second", 1))
        assert world.snapshot().source.name == "second"

        undo(world, "ann")

        assert world.snapshot().source.name == "mine"


def test_the_scene_is_known_after_a_compaction_that_forgets_its_loading(tmp_path: Path, scene: Path) -> None:
    with open_data(tmp_path / "data", str(scene)) as directory:
        with directory.world.transaction("ann", "weighed") as tx:
            tx.set("starter_1", "sk:mass", 0.7)
        directory.compact(keep=0)

    assert reason(tmp_path / "data", scene) == ""


_LOAD_AND_DIE = """
import os, signal, sys
from skiros_py.station.worlds import open_data
from skiros_py.world.change import SceneSource

directory = open_data(sys.argv[1], create=False)
with directory.world.transaction("ann", "loads") as tx:
    tx.set("starter_1", "sk:mass", 0.7)
    tx.set_source(SceneSource("second", 1))
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_process_killed_right_after_it_loaded_a_scene_leaves_its_content_and_its_name(
    tmp_path: Path, scene: Path
) -> None:
    reason(tmp_path / "data", scene)

    ended = subprocess.run([sys.executable, "-c", _LOAD_AND_DIE, tmp_path / "data"], check=False)

    assert ended.returncode == -signal.SIGKILL
    with open_data(tmp_path / "data", create=False) as directory:
        assert directory.world.element("starter_1").properties["sk:mass"] == 0.7
        assert directory.world.snapshot().source == ("second", 1)
