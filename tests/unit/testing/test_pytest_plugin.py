"""What the pytest plug-in gives to the tests of somebody's package."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from skiros_py.testing import TINY_ONTOLOGY

pytest_plugins = "pytester"

SKILL = """
import pytest
from skiros_py.testing.tiny import DRIVE, PICK, pretend

TURTLE = "scene:box_a a tiny:Box ; sk:on scene:floor . scene:ball_1 a tiny:Ball ; sk:in scene:box_a ."
"""


@pytest.fixture
def tests(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """A folder of tests in an environment where a distribution names the plug-in, as this one's does."""
    info = pytester.mkdir("site") / "sk_plugin-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: sk-plugin\nVersion: 1.0\n", encoding="utf-8")
    points = "[pytest11]\nskiros = skiros_py.testing.pytest_plugin\n"
    (info / "entry_points.txt").write_text(points, encoding="utf-8")
    monkeypatch.syspath_prepend(str(info.parent))
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(TINY_ONTOLOGY))
    return pytester


def ran(tests: pytest.Pytester, text: str) -> pytest.RunResult:
    tests.makepyfile(SKILL + text)
    return tests.runpytest_inprocess("-p", "no:dash", "--strict-markers", "-W", "ignore::DeprecationWarning")


def test_a_marked_test_gets_the_world_of_its_scene(tests: pytest.Pytester) -> None:
    result = ran(
        tests,
        """
@pytest.mark.skiros_scene("kitting")
def test_by_name(skiros_world):
    assert skiros_world.has("kit_1")

@pytest.mark.skiros_scene(TURTLE, robots=2)
def test_turtle(skiros_world):
    assert skiros_world.instances("sk:Robot") == ("robot_1", "robot_2")

@pytest.mark.skiros_scene(TURTLE)
class TestOfAClass:
    def test_changes_it(self, skiros_world):
        with skiros_world.transaction("test", "by hand") as tx:
            tx.remove("ball_1")

    def test_gets_a_new_one(self, skiros_world):
        assert skiros_world.has("ball_1")
""",
    )

    result.assert_outcomes(passed=4)


def test_the_ini_file_names_the_scene_of_tests_that_do_not(tests: pytest.Pytester) -> None:
    tests.makeini("[pytest]\nskiros_scene = kitting\n")
    result = ran(tests, "def test_it(skiros_world):\n    assert skiros_world.has('kit_1')\n")

    result.assert_outcomes(passed=1)


def test_without_a_scene_the_test_is_told_how_to_name_one(tests: pytest.Pytester) -> None:
    result = ran(tests, "def test_it(skiros_world):\n    pass\n")

    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["*which scene? mark the test with @pytest.mark.skiros_scene*"])


def test_a_session_and_a_bench_are_opened_on_the_scene_and_closed(tests: pytest.Pytester) -> None:
    result = ran(
        tests,
        """
@pytest.mark.skiros_scene("kitting")
def test_session(skiros_session):
    assert skiros_session.run(["RobotAtLocation(robot_1, pallet_a)"]).reached

@pytest.mark.skiros_scene("kitting")
def test_bench(skiros_bench):
    assert skiros_bench.pursue("RobotAtLocation(robot_1, pallet_a)").reached
""",
    )

    result.assert_outcomes(passed=2)


def test_a_failed_trial_prints_the_tree_of_reasons_and_the_events(tests: pytest.Pytester) -> None:
    result = ran(
        tests,
        """
@pytest.mark.skiros_scene(TURTLE)
def test_picks(run_skill):
    assert run_skill(pretend(DRIVE), Location="box_a")
    assert run_skill(pretend(PICK), Ball="ball_1", Gripper="gripper_1", Box="floor")

@pytest.mark.skiros_scene(TURTLE)
def test_drives(run_skill):
    assert run_skill(pretend(DRIVE), Location="box_a")
""",
    )

    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(
        [
            "*assert <pick failed: *",
            "*skiros: <drive succeeded: pretended>*",
            "*At(robot_1, box_a) (holds)*",
            "*~ robot_1 sk:at unknown_location -> sk:at box_a*",
            "*skiros: <pick failed: *",
            "*Holding(gripper_1, ball_1) (does not hold)*",
            "*skill pick: error*",
        ]
    )


def test_a_passing_test_prints_nothing(tests: pytest.Pytester) -> None:
    result = ran(
        tests,
        """
@pytest.mark.skiros_scene(TURTLE)
def test_drives(run_skill):
    assert run_skill(pretend(DRIVE), Location="box_a")
""",
    )

    result.assert_outcomes(passed=1)
    result.stdout.no_fnmatch_line("*skiros:*")


def test_pytest_starts_without_anything_heavy(tmp_path: Path) -> None:
    program = """
import sys
import skiros_py.testing.pytest_plugin
heavy = {"numpy", "scipy", "rdflib", "pyoxigraph", "shapely", "pybullet"}
print(sorted(heavy & set(sys.modules)))
print(sorted(name for name in sys.modules if name.startswith("skiros_py")))
"""

    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=tmp_path)

    assert done.stdout.splitlines() == ["[]", "['skiros_py', 'skiros_py.testing', 'skiros_py.testing.pytest_plugin']"]
