"""Robots and scenes that distributions bring by entry points: imported, opened by name, listed without running code."""

from __future__ import annotations

import json
import sys
from typing import Any

import pytest
from click.testing import CliRunner

from skiros_py.cli.main import cli
from skiros_py.config import find_scene, named_scene, scene_names
from skiros_py.errors import FileError, UnknownName, UsageError
from skiros_py.station.worlds import open_world
from skiros_py.testing import TINY_ONTOLOGY, tiny_scene

ROBOT = """
@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix tiny: <https://w3id.org/skiros-py/testing/tiny#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
<http://example.org/robots/crane> a owl:Ontology .
scene:crane_1 a tiny:Box ; sk:on scene:floor .
"""
BREAKS = "raise SystemExit"


@pytest.fixture(autouse=True)
def _tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(TINY_ONTOLOGY))


@pytest.fixture
def scene(tmp_path: Any) -> str:
    """Text of a scene that imports the crane."""
    text: str = tiny_scene(tmp_path).read_text(encoding="utf-8")
    tiny, owl = "https://w3id.org/skiros-py/scenes/tiny", "http://www.w3.org/2002/07/owl#"
    return f"{text}\n<{tiny}> <{owl}imports> <http://example.org/robots/crane> .\n"


def opened(tmp_path: Any, text: str) -> Any:
    file = tmp_path / "with_crane.ttl"
    file.write_text(text, encoding="utf-8")
    return open_world(str(file))


@pytest.mark.parametrize("name", ["crane", "lifting_gear"])
def test_a_scene_imports_the_robot_of_a_plugin_by_its_iri(site: Any, tmp_path: Any, scene: str, name: str) -> None:
    site.install("sk-crane", {"robots": {name: "sk_crane"}}, {"sk_crane/__init__.py": BREAKS, "sk_crane/c.ttl": ROBOT})

    assert opened(tmp_path, scene).has("crane_1")


def test_no_more_robots_are_loaded_than_needed(site: Any, tmp_path: Any, scene: str) -> None:
    point = "import pathlib\nHERE = pathlib.Path(__file__).with_name('crane.ttl')"
    files = {"sk_cr_a.py": point, "sk_cr_b.py": point, "crane.ttl": ROBOT}
    site.install("sk-cranes", {"robots": {"another": "sk_cr_b:HERE", "crane": "sk_cr_a:HERE"}}, files)

    opened(tmp_path, scene)

    assert "sk_cr_a" in sys.modules
    assert "sk_cr_b" not in sys.modules


@pytest.mark.parametrize(
    ("value", "files", "says"),
    [
        ("sk_bad_a:HERE", {"sk_bad_a.py": BREAKS}, "SystemExit: "),
        ("sk_bad_b", {"sk_bad_b/a.ttl": "no turtle"}, "a.ttl:1: not Turtle"),
        ("sk_bad_c", {"sk_bad_c/__init__.py": ""}, "there is no Turtle file below"),
        ("sk_bad_d", {}, "the entry point is stale"),
    ],
)
def test_a_scene_whose_robot_is_broken_says_which_plugin_and_why(
    site: Any, tmp_path: Any, scene: str, value: str, files: dict[str, str], says: str
) -> None:
    site.install("sk-crane", {"robots": {"crane": value}}, files)

    with pytest.raises(FileError, match=r"imports <http://example.org/robots/crane>, which no file at hand") as caught:
        opened(tmp_path, scene)

    assert "plug-in crane of sk-crane 0.3 did not load: " in str(caught.value)
    assert says in str(caught.value)
    open_world(str(tiny_scene(tmp_path)))  # nobody else needs it


def test_scenes_of_a_package_are_listed_and_opened_by_name_without_its_code(site: Any, tmp_path: Any) -> None:
    text = tiny_scene(tmp_path).read_text(encoding="utf-8")
    files = {"sk_sc/__init__.py": BREAKS, "sk_sc/scenes/hall.ttl": text, "sk_sc/scenes/yard.owl": text}
    site.install("sk-scenes", {"scenes": {"ours": "sk_sc"}}, files)

    assert {"hall", "yard", "kitting"} <= set(scene_names())
    assert named_scene("hall") == find_scene("hall") == site.folder / "sk_sc" / "scenes" / "hall.ttl"
    assert open_world("hall").has("ball_1")
    listed = json.loads(CliRunner().invoke(cli, ["scene", "list", "--json"]).output)["scenes"]
    assert listed["yard"].endswith("yard.owl")


def test_a_scene_opened_by_path_has_the_name_of_its_entry_point(site: Any, tmp_path: Any) -> None:
    files = {"sk_one.py": "import pathlib\nX = pathlib.Path(__file__).with_name('file.ttl')", "file.ttl": ""}
    site.install("sk-scenes", {"scenes": {"hall": "sk_one:X"}}, files)

    assert "hall" in scene_names()
    assert "sk_one" not in sys.modules
    assert named_scene("hall") == site.folder / "file.ttl"


def test_an_own_scene_takes_precedence_over_a_plug_in_scene(site: Any) -> None:
    site.install("sk-scenes", {"scenes": {"ours": "sk_hide"}}, {"sk_hide/kitting.ttl": ""})

    assert not named_scene("kitting").is_relative_to(site.folder)


def test_a_scene_name_provided_by_two_plug_ins_is_qualified_by_their_distributions(site: Any) -> None:
    site.install("sk-a", {"scenes": {"a": "sk_sa"}}, {"sk_sa/hall.ttl": ""})
    site.install("sk-b", {"scenes": {"b": "sk_sb"}}, {"sk_sb/hall.ttl": ""})

    assert named_scene("sk-a.hall") == site.folder / "sk_sa" / "hall.ttl"
    assert named_scene("sk-b.hall") == site.folder / "sk_sb" / "hall.ttl"
    with pytest.raises(UnknownName, match=r"Did you mean 'sk-a\.hall'"):
        named_scene("hall")


@pytest.mark.parametrize(
    ("value", "files", "says"),
    [
        ("sk_sx:X", {"sk_sx.py": BREAKS}, "plug-in hall of sk-scenes 0.3 did not load: SystemExit"),
        ("sk_sy:X", {"sk_sy.py": "X = 5"}, "it is a int, nothing for scenes: name a package, or a Path"),
        (
            "sk_sz:X",
            {"sk_sz.py": "import pathlib\nX = pathlib.Path('/nowhere.ttl')"},
            "there is no scene file /nowhere",
        ),
    ],
)
def test_opening_a_scene_of_a_broken_plug_in_gives_the_reason(
    site: Any, value: str, files: dict[str, str], says: str
) -> None:
    site.install("sk-scenes", {"scenes": {"hall": value}}, files)

    with pytest.raises(UsageError, match="hall") as caught:
        named_scene("hall")

    assert says in str(caught.value)


def test_an_unknown_scene_is_answered_with_all_scenes_including_those_of_plug_ins(site: Any) -> None:
    site.install("sk-scenes", {"scenes": {"ours": "sk_near"}}, {"sk_near/assembly_hall.ttl": ""})

    with pytest.raises(UnknownName, match="Did you mean 'assembly_hall'"):
        named_scene("assembly_hal")
