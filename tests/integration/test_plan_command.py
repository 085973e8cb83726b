"""``skiros plan --explain-domain``: what an author reads of what was made of his skills."""

from __future__ import annotations

import json
import subprocess

from support import warm_python


def skiros(*arguments: str) -> subprocess.CompletedProcess[str]:
    return warm_python.run([*warm_python.SKIROS, *arguments], timeout=120)


def test_the_explanation_lists_what_was_added_to_each_skill_and_why() -> None:
    result = skiros("plan", "kitting", "--explain-domain")

    assert result.returncode == 0, result.stderr
    told = " ".join(result.stdout.replace("│", " ").split())
    assert "can_pick(Arm): who has the skill" in told
    assert "Robot_from" in told
    assert "bookkeeping of the goal" in told
    assert "(define" not in told


def test_the_explanation_is_available_as_json_with_domain_and_plan() -> None:
    result = skiros("plan", "kitting", "--explain-domain", "--json")

    answer = json.loads(result.stdout)
    skills = {told["skill"]: told for told in answer["skills"]}
    assert {"drive", "pick", "place"} <= set(skills)
    assert "CanBeWorkedAt(Location)" in skills["drive"]["pre"]
    assert all(action["notes"] for told in answer["skills"] for action in told["actions"])
    assert answer["steps"]
    assert answer["domain"].startswith("(define")


def test_a_temporal_plan_has_durative_actions() -> None:
    result = skiros("plan", "kitting", "--temporal")

    assert result.returncode == 0, result.stderr
    assert "(:requirements :strips :typing :durative-actions)" in result.stdout


def test_a_planner_without_time_support_is_refused_with_the_unsupported_features() -> None:
    result = skiros("plan", "kitting", "--temporal", "--planner", "fast-downward")

    assert result.returncode == 1
    assert "fast-downward does not take :durative-actions" in result.stderr
