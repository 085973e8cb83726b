"""A name that stands for two things of one distribution is an error that names both; neither counts."""

from __future__ import annotations

from typing import Any

import pytest

from skiros_py.catalogue import Catalogue, load_catalogue

HEAD = """
from dataclasses import dataclass, replace
from skiros_py.skills.primitive import Primitive
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, PICK, pretend
HOP = replace(DRIVE, name="hop")
OTHER = replace(HOP, help="Something else.")
A, B, C = pretend(HOP), pretend(replace(HOP)), pretend(OTHER)
SWIM = pretend(replace(DRIVE, name="swim"))
FAST, QUICK = replace(A, label="fast"), replace(B, label="fast")
REAL = replace(FAST, driver=None)
BOTH = (A, SWIM)
class Hop(Primitive):
    name = "hop"
    @dataclass(frozen=True)
    class Params: pass
    def execute(self): yield
class Dive(Hop):
    name = "dive"
NEAR = replace(AT_LOCATION, name="Near")
SAME = replace(NEAR)
ELSE = replace(NEAR, help="Something else.")
"""


@pytest.fixture
def given(site: Any, request: pytest.FixtureRequest) -> Any:
    """Loads the catalogue with two distributions that bring what is asked for, from a module of the test's own."""
    module = f"sk_clash_{request.node.name}"
    (site.folder / f"{module}.py").write_text(HEAD, encoding="utf-8")

    def load(one: dict[str, dict[str, str]], two: dict[str, dict[str, str]] | None = None) -> Catalogue:
        for name, groups in (("one", one), ("two", two or {})):
            named = {g: {n: f"{module}:{v}" for n, v in own.items()} for g, own in groups.items()}
            site.install(f"sk-{name}", named)
        return load_catalogue()

    return load


def told(catalogue: Catalogue) -> dict[str, str]:
    return {fault.name: fault.reason for fault in catalogue.faults if fault.distribution.startswith("sk-")}


def test_several_implementations_of_one_description_do_not_clash(given: Any) -> None:
    catalogue = given({"skills": {"a": "A"}}, {"skills": {"b": "B", "fast": "FAST", "real": "REAL"}})

    assert {"a", "b", "fast", "real"} <= set(catalogue.skills)
    assert told(catalogue) == {}


def test_two_different_descriptions_with_one_name_are_both_left_out(given: Any) -> None:
    catalogue = given({"skills": {"a": "A", "swim": "SWIM", "c": "C"}})

    assert "swim" in catalogue.skills
    assert not {"a", "c"} & set(catalogue.skills)
    expected = "there is more than one description of skill 'hop': a of sk-one 0.3 and c of sk-one 0.3; none of them"
    assert {name: reason[: len(expected)] for name, reason in told(catalogue).items()} == {"a": expected, "c": expected}


def test_two_implementations_with_one_label_are_both_left_out(given: Any) -> None:
    catalogue = given({"skills": {"a": "A", "fast": "FAST", "quick": "QUICK"}})

    assert "a" in catalogue.skills
    assert not {"fast", "quick"} & set(catalogue.skills)
    assert (
        "implementation of 'hop' called 'fast': fast of sk-one 0.3 and quick of sk-one 0.3" in told(catalogue)["fast"]
    )


def test_a_skill_and_a_primitive_with_one_name_are_both_left_out(given: Any) -> None:
    catalogue = given({"skills": {"a": "A"}, "primitives": {"hop": "Hop", "dive": "Dive"}})

    assert "a" not in catalogue.skills
    assert "hop" not in catalogue.primitives
    assert "dive" in catalogue.primitives
    assert set(told(catalogue)) == {"a", "hop"}
    assert all("(a of sk-one 0.3) and of a primitive (sk-one 0.3" in reason for reason in told(catalogue).values())


def test_a_condition_with_two_meanings_is_left_out_and_one_under_two_names_is_kept(given: Any) -> None:
    catalogue = given({"conditions": {"Near": "NEAR", "Same": "SAME"}})
    assert {"Near", "Same"} <= set(catalogue.conditions)


def test_a_condition_with_two_meanings_is_left_out(given: Any) -> None:
    catalogue = given({"conditions": {"Near": "NEAR", "Else": "ELSE"}})

    assert not {"Near", "Else"} & set(catalogue.conditions)
    assert "condition 'Near': Else of sk-one 0.3 and Near of sk-one 0.3" in told(catalogue)["Near"]


def test_one_entry_point_may_name_several_skills(given: Any) -> None:
    catalogue = given({"skills": {"moves": "BOTH"}})

    assert {catalogue.skills[key].description.name for key in ("moves[1]", "moves[2]")} == {"hop", "swim"}
    assert catalogue.sources["skills/moves[2]"] == "sk-one 0.3"
