"""Skills that call skills are worth as much as what they call."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import pytest

from skiros_py.behaviours import AssertEffects, Do, Fallback
from skiros_py.catalogue import Catalogue, fitting
from skiros_py.skills.skill import Skill
from skiros_py.testing import CONDITIONS, tiny_ontology
from skiros_py.testing.tiny import DRIVE, pretend

Fitted = tuple[set[str], Mapping[str, str]]


def skill(name: str, *calls: str, label: str = "") -> Skill:
    body = Fallback.of(*map(Do.of, calls), AssertEffects())
    return replace(pretend(replace(DRIVE, name=name), body), label=label)


def fitted(fake: bool | None = None, **skills: Skill) -> Fitted:
    found = fitting(Catalogue(skills, {}, CONDITIONS, {}, {}), tiny_ontology(), fake=fake)
    return set(found.skills), {fault.name: fault.reason for fault in found.faults}


@pytest.mark.parametrize("fake", [True, None])
def test_a_skill_may_call_a_skill_that_is_there(fake: bool | None) -> None:
    assert fitted(fake, hop=skill("hop"), tour=skill("tour", "hop")) == ({"hop", "tour"}, {})


def test_a_skill_may_be_listed_before_the_skills_it_calls_and_may_call_itself() -> None:
    assert fitted(a=skill("tour", "hop", "tour"), b=skill("hop")) == ({"a", "b"}, {})


def test_a_broken_skill_and_all_its_callers_are_left_out_with_a_reason() -> None:
    good, reasons = fitted(
        trip=skill("trip", "tour"), tour=skill("tour", "hop"), hop=skill("hop", "fly"), own=skill("own")
    )

    assert good == {"own"}
    assert reasons["hop"].startswith("there is no primitive or skill 'fly'")
    assert reasons["tour"] == f"it calls 'hop': {reasons['hop']}"
    assert reasons["trip"] == f"it calls 'tour': {reasons['tour']}"


def test_a_skill_is_kept_if_another_implementation_of_its_callee_exists() -> None:
    broken, good = skill("hop", "fly", label="high"), skill("hop", label="low")

    assert fitted(high=broken, low=good, tour=skill("tour", "hop"))[0] == {"low", "tour"}


@pytest.mark.parametrize(
    "real", [lambda s: replace(s, driver=None, body=Do.of("hop")), lambda s: replace(s, driver="x", body=Do.of("hop"))]
)
def test_a_skill_for_real_robots_cannot_call_a_fake_only_skill(real: Callable[[Skill], Skill]) -> None:
    good, reasons = fitted(hop=skill("hop"), tour=real(skill("tour")))

    assert good == {"hop"}
    assert reasons["tour"].startswith("there is no primitive or skill 'hop'")


def test_a_refined_skill_is_left_out_where_the_ontology_lets_its_agents_have_the_general_one_too() -> None:
    refined = pretend(DRIVE.refined("creep", DRIVE.agent_class, help="Drives slowly."))

    good, reasons = fitted(creep=refined)

    assert good == set()
    assert reasons["creep"].endswith(f'the ontology must say of {DRIVE.agent_class}: sk:refinedSkills "{DRIVE.name}"')


def test_a_skill_for_real_robots_that_asserts_unsensed_effects_is_left_out() -> None:
    good, reasons = fitted(hop=replace(skill("hop"), driver=None), tour=skill("tour"))

    assert good == {"tour"}
    assert "asserts effects without sensing them" in reasons["hop"]
