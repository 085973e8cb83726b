"""``skiros scene`` as people type it, each time in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

from support import warm_python

from skiros_py.config import find_scene
from skiros_py.station.worlds import open_data

ROOT = Path(__file__).parents[2]
HEADER = """@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix kitting: <https://w3id.org/skiros-py/kitting#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
scene:floor a sk:Floor .
"""


def skiros(*arguments: str, cwd: Path | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    return warm_python.run([*warm_python.SKIROS, *arguments], cwd=cwd, env={**os.environ, **environment})


def test_scenes_are_listed_with_their_files(tmp_path: Path) -> None:
    (tmp_path / "mine.ttl").write_text(HEADER, encoding="utf-8")

    result = skiros("scene", "list", "--json", SKIROS_SCENES=str(tmp_path))

    scenes = json.loads(result.stdout)["scenes"]
    assert scenes["mine"] == str(tmp_path / "mine.ttl")
    assert scenes["kitting"].endswith("kitting.ttl")


def test_a_saved_copy_is_equal_and_copying_it_again_gives_the_same_file(tmp_path: Path) -> None:
    saved = skiros("scene", "save", "kitting", "one.ttl", cwd=tmp_path)
    again = skiros("scene", "save", "one.ttl", "two.ttl", cwd=tmp_path)
    compared = skiros("scene", "diff", "kitting", "one.ttl", cwd=tmp_path)

    assert (saved.returncode, again.returncode, compared.returncode) == (0, 0, 0)
    assert (tmp_path / "one.ttl").read_text() == (tmp_path / "two.ttl").read_text()
    assert compared.stdout == ""


def test_scenes_that_differ_end_with_status_one_and_what_is_different() -> None:
    told = skiros("scene", "diff", "kitting", "kitting_carried")
    as_json = skiros("scene", "diff", "kitting", "kitting_carried", "--json")

    assert told.returncode == as_json.returncode == 1
    assert "~ kit_1 sk:on kit_table -> sk:on deck_1" in told.stdout.splitlines()
    assert "- kit_table (kitting:Table) 'kit table'" in told.stdout.splitlines()
    edits = json.loads(as_json.stdout)["edits"]
    assert {
        "edit": "placement",
        "element": "kit_table",
        "old": {"relation": "sk:on", "place": "floor"},
        "new": None,
    } in edits


def test_a_scene_is_checked_with_its_goal(tmp_path: Path) -> None:
    (tmp_path / "good.ttl").write_text(HEADER, encoding="utf-8")
    (tmp_path / "bad.ttl").write_text(f'{HEADER}scene:this sk:goal "Fly(me, moon)" .', encoding="utf-8")
    (tmp_path / "worse.ttl").write_text(f"{HEADER}scene:a a kitting:Kit .", encoding="utf-8")

    good, bad, worse = (skiros("scene", "check", f"{name}.ttl", cwd=tmp_path) for name in ("good", "bad", "worse"))

    assert (good.returncode, bad.returncode, worse.returncode) == (0, 2, 2)
    assert good.stdout == "good.ttl: 1 elements, 0 goals, nothing wrong\n"
    assert "bad.ttl: sk:goal: " in bad.stderr
    assert "worse.ttl:5: a (kitting:Kit) is nowhere" in worse.stderr


def test_a_scene_check_finds_a_scene_of_which_no_cell_can_be_built(tmp_path: Path) -> None:
    text = find_scene("kitting").read_text(encoding="utf-8")
    panda = (ROOT / "robots/src/skiros_robots/mobile_panda_devices.ttl").read_text(encoding="utf-8")
    camera = panda[panda.index("scene:camera_1 a sk:Camera") :].replace("camera_1", "eye")
    camera = camera.replace("camera_optical", "nowhere") + "scene:arm_1 sk:hasA scene:eye .\n"
    (tmp_path / "camera.ttl").write_text(text + camera, encoding="utf-8")

    result = skiros("scene", "check", "camera.ttl", cwd=tmp_path)

    assert result.returncode == 2
    assert "camera.ttl: eye, in the model 'mobile_panda': unknown link 'nowhere'" in result.stderr


def test_a_refused_scene_is_not_saved_and_the_old_file_stays(tmp_path: Path) -> None:
    (tmp_path / "bad.ttl").write_text(f"{HEADER}scene:a a kitting:Kit .", encoding="utf-8")
    (tmp_path / "old.ttl").write_text("old", encoding="utf-8")

    result = skiros("scene", "save", "bad.ttl", "old.ttl", cwd=tmp_path)

    assert result.returncode == 2
    assert "Traceback" not in result.stderr
    assert (tmp_path / "old.ttl").read_text(encoding="utf-8") == "old"


def test_saving_without_required_options_names_them(tmp_path: Path) -> None:
    alone = skiros("scene", "save", "one.ttl", cwd=tmp_path)
    other = skiros("scene", "save", "kitting", "one.owl", cwd=tmp_path)

    assert (alone.returncode, other.returncode) == (2, 2)
    assert "give SCENE and FILE" in alone.stderr
    assert "must end in .ttl" in other.stderr
    assert not list(tmp_path.iterdir())


def test_the_current_world_of_a_data_directory_can_be_saved(tmp_path: Path) -> None:
    with open_data(tmp_path / "data", "kitting") as data, data.world.transaction("look", "seen") as tx:
        tx.set("starter_1", "sk:missing", True)

    saved = skiros("scene", "save", "--data", "data", "now.ttl", cwd=tmp_path)
    compared = skiros("scene", "diff", "kitting", "now.ttl", cwd=tmp_path)
    nowhere = skiros("scene", "save", "--data", "nowhere", "now.ttl", cwd=tmp_path)

    assert (saved.returncode, nowhere.returncode) == (0, 2)
    assert compared.stdout == "+ starter_1 sk:missing true\n"
    assert not (tmp_path / "nowhere").exists()
