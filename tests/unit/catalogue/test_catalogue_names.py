"""Two distributions that use one name for different things both keep what they offer, under names that differ."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from skiros_py.catalogue import Catalogue, load_catalogue
from skiros_py.errors import UnknownName
from skiros_py.execution.loader import read_configuration
from skiros_py.plugins.installation import installation
from skiros_py.skills.behaviour import calls_of
from skiros_py.tasks.goals import parse_goal
from skiros_py.testing.tiny import tiny_world

HEAD = """
from dataclasses import dataclass, replace
from skiros_py.behaviours import Check, Do, Sequence, Wait
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, pretend
HOP = replace(DRIVE, name="hop", help="Hops as {0} does.")
NEAR = replace(AT_LOCATION, name="Near", help="As {0} means it.")
A = pretend(HOP)
B = pretend(replace(HOP, post=(NEAR("Robot", "Location"),)))
BODY = Sequence.of(Do.of("hop"), Do.of("wave"), Check((NEAR("Robot", "Location"),)))
TOUR = Skill(replace(DRIVE, name="tour_{0}"), BODY, driver="fake")
class Wave(Primitive):
    name = "wave"
    @dataclass(frozen=True)
    class Params: pass
    def execute(self):
        return (yield from self.call("hop"))
class Wait(Wait):
    kind = "wait"
"""


@pytest.fixture
def two(site: Any, request: pytest.FixtureRequest) -> Any:
    """Installs two distributions with the same entry points, each from a module of its own."""

    def install(groups: dict[str, dict[str, str]]) -> Catalogue:
        for name in ("one", "two"):
            module = f"sk_names_{name}_{abs(hash(request.node.name))}"
            named = {g: {n: f"{module}:{v}" for n, v in own.items()} for g, own in groups.items()}
            site.install(f"sk-{name}", named, {f"{module}.py": HEAD.replace("{0}", name)})
        return load_catalogue()

    return install


def faults(catalogue: Catalogue) -> list[str]:
    catalogue.load_all()
    return [fault.reason for fault in catalogue.faults if fault.distribution.startswith("sk-")]


def test_two_skills_with_one_name_are_both_offered_qualified_by_their_distributions(two: Any) -> None:
    catalogue = two({"skills": {"hop": "A"}})

    assert faults(catalogue) == []
    names = {key: skill.description.name for key, skill in catalogue.skills.items() if "hop" in key}
    assert names == {"sk-one.hop": "sk-one.hop", "sk-two.hop": "sk-two.hop"}


def test_skills_go_on_calling_the_modules_and_using_the_conditions_of_their_own_distribution(two: Any) -> None:
    catalogue = two(
        {"skills": {"hop": "A", "tour": "TOUR"}, "primitives": {"wave": "Wave"}, "conditions": {"Near": "NEAR"}}
    )

    assert faults(catalogue) == []
    for name in ("one", "two"):
        tour = catalogue.skills[f"sk-{name}.tour"]
        assert tour.description.name == f"tour_{name}"
        assert [call.module for call in calls_of(tour.body)] == [f"sk-{name}.hop", f"sk-{name}.wave"]
        assert f"sk-{name}.Near" in repr(tour.body)
        wave = catalogue.primitives[f"sk-{name}.wave"]
        assert (wave.name, dict(wave.offered)) == (
            f"sk-{name}.wave",
            {"hop": f"sk-{name}.hop", "wave": f"sk-{name}.wave"},
        )


def test_a_goal_may_use_the_qualified_word_of_a_condition(two: Any) -> None:
    catalogue = two({"conditions": {"Near": "NEAR"}})

    (condition,) = parse_goal(["not sk-two.Near(robot_1, box_a)"], tiny_world(), catalogue.conditions)

    assert str(condition) == "not sk-two.Near(robot_1, box_a)"
    assert condition.type.help == "As two means it."
    assert "Near" not in catalogue.conditions


def test_names_stay_qualified_when_the_other_distribution_is_left_out_and_own_names_are_understood_too(
    two: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    groups = {"skills": {"hop": "B"}, "primitives": {"wave": "Wave"}, "conditions": {"Near": "NEAR"}}
    both = two(groups)
    with pytest.raises(UnknownName, match=r"Did you mean 'sk-(one|two)\.Near'"):
        parse_goal(["Near(robot_1, box_a)"], tiny_world(), both.conditions)

    monkeypatch.setenv("SKIROS_WITHOUT", "sk-one")
    catalogue = load_catalogue()

    assert "sk-one" not in " ".join((*catalogue.skills, *catalogue.primitives, *catalogue.conditions))
    assert catalogue.skills["sk-two.hop"].description.name == "sk-two.hop"
    assert catalogue.primitives["sk-two.wave"].name == catalogue.primitives["wave"].name == "sk-two.wave"
    assert "wave" not in both.primitives
    for word in ("sk-two.Near", "Near", "near"):
        (condition,) = parse_goal([f"{word}(robot_1, box_a)"], tiny_world(), catalogue.conditions)
        assert str(condition) == "sk-two.Near(robot_1, box_a)"


def test_the_own_name_of_an_entry_point_may_begin_with_that_of_its_distribution(site: Any) -> None:
    text = HEAD.replace("{0}", "lab").replace('name = "wave"', 'name = "lab.wave"')
    site.install("lab", {"primitives": {"lab.wave": "sk_lab_own:Wave"}}, {"sk_lab_own.py": text})

    (entry,) = (one for one in installation().of("skiros.primitives") if one.distribution.name == "lab")
    assert (entry.name, entry.own_name) == ("lab.wave", "lab.wave")
    assert load_catalogue().primitives["lab.wave"].name == "lab.wave"

    site.install("other", {"primitives": {"lab.wave": "sk_lab_own:Wave"}})
    offered = {(one.name, one.own_name) for one in installation().of("skiros.primitives") if "wave" in one.name}
    assert offered == {("lab.lab.wave", "lab.wave"), ("other.lab.wave", "lab.wave")}
    assert load_catalogue().primitives["lab.lab.wave"].name == "lab.lab.wave"


def test_a_goal_may_use_a_word_of_a_distribution_whose_name_begins_with_a_digit(site: Any) -> None:
    for name in ("3d-lab", "4d-lab"):
        module = f"sk_digit_{name[0]}"
        text = HEAD.replace("{0}", name[0])
        site.install(name, {"conditions": {"Near": f"{module}:NEAR"}}, {f"{module}.py": text})
    catalogue, world = load_catalogue(), tiny_world()

    assert faults(catalogue) == []
    (condition,) = parse_goal(
        ["3d-lab.Near(robot_1, box_a) and not 4d-lab.Near(robot_1, box_a)"], world, catalogue.conditions
    )[:1]
    assert str(condition) == "3d-lab.Near(robot_1, box_a)"
    assert parse_goal([f"{condition}"], world, catalogue.conditions) == (condition,)


def test_a_node_named_as_a_built_in_one_is_read_and_written_under_its_qualified_name(two: Any) -> None:
    catalogue = two({"behaviours": {"wait": "Wait"}})

    assert faults(catalogue) == []
    assert catalogue.behaviours["wait"].__module__ == "skiros_py.behaviours.wait"
    own = catalogue.behaviours["sk-one.wait"]
    assert own(1.0).to_data() == {"type": "sk-one.wait", "seconds": 1.0}


def test_a_skill_named_as_a_built_in_one_leaves_the_bare_name_to_it(two: Any, site: Any) -> None:
    site.install("skiros-skills", {"skills": {"hop": "sk_built_in_hop:A"}}, {"sk_built_in_hop.py": HEAD}, version="9")

    catalogue = two({"skills": {"hop": "A"}})

    assert {key for key in catalogue.skills if "hop" in key} == {"hop", "sk-one.hop", "sk-two.hop"}
    assert catalogue.skills["hop"].description.name == "hop"
    assert catalogue.sources["skills/hop"] == "skiros-skills 9"


def test_implementations_with_one_label_are_both_offered_and_a_built_in_one_keeps_its_label(site: Any) -> None:
    for name in ("skiros-skills", "sk-one"):
        module = f"sk_label_{name.replace('-', '_')}"
        text = HEAD.replace("{0}", "all") + 'FAST = replace(A, label="fast")\n'
        site.install(name, {"skills": {f"hop_{name[:4]}": f"{module}:FAST"}}, {f"{module}.py": text}, version="9")

    catalogue = load_catalogue()

    assert faults(catalogue) == []
    labels = {catalogue.sources[f"skills/{key}"]: s.label for key, s in catalogue.skills.items() if "hop" in key}
    assert labels == {"skiros-skills 9": "fast", "sk-one 9": "sk-one.fast"}


def test_a_skill_and_a_primitive_of_two_distributions_with_one_name_are_both_offered(site: Any) -> None:
    site.install("sk-one", {"skills": {"hop": "sk_both_a:A"}}, {"sk_both_a.py": HEAD})
    text = HEAD.replace('name = "wave"', 'name = "hop"')
    site.install("sk-two", {"primitives": {"hop": "sk_both_b:Wave"}}, {"sk_both_b.py": text})

    catalogue = load_catalogue()

    assert faults(catalogue) == []
    assert catalogue.skills["hop"].description.name == "sk-one.hop"
    assert catalogue.primitives["sk-two.hop"].name == "sk-two.hop"


def test_one_distribution_with_one_name_for_two_skills_offers_neither(site: Any) -> None:
    text = HEAD + 'B = pretend(replace(HOP, help="Else."))\n'
    site.install("sk-one", {"skills": {"hop": "sk_own_clash:A", "jump": "sk_own_clash:B"}}, {"sk_own_clash.py": text})

    catalogue = load_catalogue()

    assert not {"hop", "jump"} & set(catalogue.skills)
    assert "more than one description of skill 'hop': hop of sk-one 0.3 and jump of sk-one 0.3" in faults(catalogue)[0]


def test_scenes_of_one_name_are_qualified_where_a_file_or_another_distribution_has_it(
    site: Any, tmp_path: Path
) -> None:
    from skiros_py.config import named_scene, scene_names

    for name in ("one", "two"):
        files = {f"sk_scenes_{name}/{scene}.ttl": f"# {name}" for scene in ("kitting", "yard", name)}
        site.install(f"sk-{name}", {"scenes": {"all": f"sk_scenes_{name}"}}, files)

    assert {"kitting", "sk-one.kitting", "sk-one.yard", "sk-two.yard", "one"} <= set(scene_names())
    assert "yard" not in scene_names()
    assert named_scene("sk-two.yard").read_text(encoding="utf-8") == "# two"


def test_configuration_is_given_to_a_primitive_of_a_qualified_name(two: Any) -> None:
    catalogue = two({"primitives": {"wave": "Wave"}})

    with pytest.raises(UnknownName, match=r"unknown configuration parameter 'speed' of sk-two\.wave"):
        read_configuration({"sk-two.wave.speed": "1"}, catalogue.primitives, tiny_world())


def test_an_authors_code_finds_postconditions_by_the_keys_that_they_have_in_its_distribution(two: Any) -> None:
    catalogue = two({"skills": {"hop": "B"}, "conditions": {"Near": "NEAR"}})

    post = [skill.description.post for key, skill in catalogue.skills.items() if key.endswith(".hop")]
    assert [(str(c), c.key) for (c,) in post] == [
        (f"sk-{name}.Near(Robot, Location)", "Near(Robot, Location)") for name in ("one", "two")
    ]
