"""Who reads what a skill needs can ask for it: every condition of the built-in skills is a word for goals."""

from __future__ import annotations

import tomllib
from pathlib import Path

from skiros_py.skills.conditions import ConditionType
from skiros_skills import conditions


def test_every_condition_has_an_entry_point_under_its_name() -> None:
    text = (Path(__file__).parents[2] / "skills" / "pyproject.toml").read_text(encoding="utf-8")
    entries = tomllib.loads(text)["project"]["entry-points"]["skiros.conditions"]

    assert entries == {
        condition.name: f"{conditions.__name__}:{constant}"
        for constant, condition in vars(conditions).items()
        if isinstance(condition, ConditionType) and not constant.startswith("_")
    }
