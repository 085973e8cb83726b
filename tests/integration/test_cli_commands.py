"""The commands as people type them, each in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

SKIROS = Path(sys.executable).parent / "skiros"


def skiros(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([str(SKIROS), *arguments], capture_output=True, text=True, check=False)


def test_a_reached_goal_ends_with_status_zero_and_one_json_object() -> None:
    result = skiros("run", "kitting", "--fake", "--json", "--goal", "InKit(Starter, kit_1)")

    report = json.loads(result.stdout)
    assert result.returncode == report["status"] == 0
    assert report["reached"]
    assert [step["skill"] for step in report["steps"]] == ["drive", "pick", "drive", "place"]
    assert "goal reached" in result.stderr


def test_without_a_plan_the_status_is_three_and_the_reason_is_given() -> None:
    result = skiros("run", "kitting", "--fake", "--json", "--goal", "ObjectAtLocation(starter_1, pallet_b)")

    report = json.loads(result.stdout)
    assert result.returncode == report["status"] == 3
    assert "pallet_b is not a Compartment" in report["no_plan"][0]
    assert report["steps"] == []


def test_a_goal_that_does_not_parse_ends_with_status_two_and_shows_the_place() -> None:
    result = skiros("run", "kitting", "--fake", "--json", "--goal", "InKit(Starter")

    assert result.returncode == json.loads(result.stdout)["status"] == 2
    assert "goal, column 14" in result.stderr


def test_a_plan_is_written_as_three_files(tmp_path: Path) -> None:
    folder = tmp_path / "deep" / "out"

    result = skiros("plan", "kitting", "--write", str(folder), "--json", "--goal", "InKit(Starter, kit_1)")

    answer = json.loads(result.stdout)
    assert result.returncode == 0
    assert (folder / "domain.pddl").read_text(encoding="utf-8") == answer["domain"]
    assert (folder / "problem.pddl").read_text(encoding="utf-8") == answer["problem"]
    assert (folder / "plan").read_text(encoding="utf-8").splitlines() == answer["plan"]
    assert len(answer["steps"]) == 4


def test_skills_are_listed_with_their_origin() -> None:
    result = skiros("skills", "--json")

    answer = json.loads(result.stdout)
    assert result.returncode == 0
    assert {"drive", "pick", "place"} <= {skill["skill"] for skill in answer["skills"].values()}
    assert answer["skills"]["pick"]["from"].startswith("skiros-skills ")
    assert "Holding(Gripper, Object)" in answer["skills"]["pick"]["post"]
    assert answer["faults"] == []


def test_skills_are_readable_by_people() -> None:
    lines = skiros("skills").stdout.splitlines()

    assert any(line.startswith("pick 1.0.0 (real, from skiros-skills") for line in lines)
    assert "  post  not EmptyHanded(Gripper)" in lines


def test_without_a_plan_no_file_is_written_and_the_previous_plan_is_removed(tmp_path: Path) -> None:
    (tmp_path / "plan").write_text("pick(Object=starter_1)", encoding="utf-8")
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")

    result = skiros("plan", "kitting", "--write", str(tmp_path), "--goal", "ObjectAtLocation(starter_1, pallet_b)")

    assert result.returncode == 3
    assert sorted(file.name for file in tmp_path.iterdir()) == ["domain.pddl", "notes.txt", "problem.pddl"]
    assert "; no plan" in result.stdout


def test_an_unwritable_folder_ends_with_status_two_and_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    folder = tmp_path / "file" / "out"

    result = skiros("plan", "kitting", "--write", str(folder), "--json", "--goal", "InKit(Starter, kit_1)")

    answer = json.loads(result.stdout)
    assert result.returncode == answer["status"] == 2
    assert str(folder) in answer["error"]
