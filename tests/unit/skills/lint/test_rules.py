"""What the rules find, and what they must leave alone; each rule's main example stands on its page."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.behaviours import (
    AssertEffects,
    Behaviour,
    Do,
    Fallback,
    ForEach,
    Out,
    P,
    Parallel,
    Policy,
    Retry,
    Sequence,
)
from skiros_py.skills.conditions import (
    AllOf,
    AnyOf,
    Compare,
    Computed,
    Condition,
    ConditionType,
    Exists,
    Expression,
    Has,
    IsA,
    Not,
    Nothing,
    Pattern,
    Related,
    Role,
    any_of,
)
from skiros_py.skills.lint.checking import RULES, check, problems_of
from skiros_py.skills.lint.rule import Finding, Known, Source, Subject
from skiros_py.skills.outcome import Outcome, Success
from skiros_py.skills.parameters import Access, Kind, Output, Param, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing import CONDITIONS, SKILLS, tiny_ontology, tiny_world
from skiros_py.testing.tiny import DRIVE, HOLDING, IN_CONTAINER, PICK, PLACE, pretend
from skiros_py.world.checks import relation_problem
from skiros_py.world.element import Placement
from skiros_py.world.reasoners.registry import Reasoners
from skiros_py.world.reasoners.sizes import SizeReasoner
from skiros_py.world.reasoners.spatial import SpatialReasoner
from skiros_py.world.terms import Family
from skiros_py.world.world import World


def _named(case: object) -> str:
    """Names a case the same in every process: functions are written with their address."""
    return re.sub(r" at 0x[0-9a-f]+", "", repr(case))


class Wave(Primitive["Wave.Params"]):
    """Waves."""

    name: ClassVar[str] = "wave"

    @dataclass(frozen=True, slots=True)
    class Params:
        arm: str = param("sk:Arm", "The arm.", kind=Kind.HARDWARE)
        times: int = param("integer", "How often.", kind=Kind.OFFLINE, default=1)

    def execute(self) -> Execution[Outcome]:
        yield
        return Success()


REASONERS = Reasoners((SizeReasoner(), SpatialReasoner()))


def known(*skills: Skill) -> Known:
    return Known(tiny_ontology(), {"wave": Wave}, (*SKILLS, *skills), REASONERS)


def findings(*subjects: Subject, skills: Iterable[Skill] = ()) -> list[Finding]:
    return [f for s in subjects for f in check(s, known(*skills), rules=RULES.values())]


def broken(*subjects: Subject, skills: Iterable[Skill] = ()) -> set[str]:
    return {finding.rule for finding in findings(*subjects, skills=skills)}


def word(pattern: Pattern, a: str = "sk:Robot", b: str = "sk:Location") -> ConditionType:
    return ConditionType("Word", (Role("a", a), Role("b", b)), pattern, "A word.")


def of_body(body: Behaviour) -> set[str]:
    skill = Skill(DRIVE, body)
    return broken(skill, skills=[skill])


# ------------------------------------------------------------------------------------------ what all is good


def test_the_tiny_skills_keep_all_rules() -> None:
    assert broken(*SKILLS, *(skill.description for skill in SKILLS), Wave) == set()


@pytest.mark.parametrize("type_", [t for t in CONDITIONS.values() if len(t.help) > 2], ids=lambda t: t.name)
def test_the_tiny_words_keep_all_rules(type_: ConditionType) -> None:
    assert broken(type_) == set()


# ------------------------------------------------------------------------------------------ words


@pytest.mark.parametrize(
    ("pattern", "said"),
    [
        (Related("sk:att", "a", "b"), "no ontology declares the relation sk:att; did you mean sk:at?"),
        (Compare("sk:misssing", "=", "b", True), "the property sk:misssing; did you mean sk:missing?"),
        (IsA("b", "tiny:Boxx"), "the class tiny:Boxx; did you mean tiny:Box?"),
        (Exists("x", "tiny:Boxx", Related("sk:at", "a", "x")), "the class tiny:Boxx"),
        (Expression("a.colour = 1"), "no sk:Robot has a signal 'colour'; there is none"),
    ],
    ids=lambda value: type(value).__name__ if not isinstance(value, str) else "",
)
def test_an_unknown_term_is_reported_with_the_most_similar_one(pattern: Pattern, said: str) -> None:
    (finding,) = findings(word(pattern))

    assert finding.rule == "unknown-word"
    assert said in finding.text


def test_terms_are_checked_in_partial_descriptions_requirements_and_bodies() -> None:
    where = Param("Spot", "tiny:Box", "A box.", where=Nothing("sk:inn", "it"))
    skill = Skill(
        replace(DRIVE, params=(*DRIVE.params, where)), ForEach("x", "tiny:Boxx", Do.of("wave")), requires=("sk:Wing",)
    )

    texts = [f.text for f in findings(skill.description, skill) if f.rule == "unknown-word"]

    assert [text.partition(":")[0] for text in texts] == ["parameter Spot", "requires", "for each x"]


# ------------------------------------------------------------------------------------------ ranges


@pytest.mark.parametrize(
    "pattern",
    [
        Related("sk:at", "b", "a"),
        Not(Related("sk:at", "b", "a")),
        AllOf((Related("sk:at", "a", "b"), Related("sk:at", "b", "a"))),
        AnyOf((Related("sk:at", "a", "b"), Related("sk:at", "b", "a"))),
        Nothing("sk:heldBy", "b"),
        Computed("tiny:fitsIn", "a", "b", lambda *_: pytest.fail("not asked")),
        Has("sk:maxGap", "b"),
        Compare("sk:missing", "=", "b", "yes"),
        Compare("sk:missing", "=", "b", 1),
        Compare("sk:model", "<", "a", 1.0),
        IsA("a", "tiny:Box"),
        Exists("x", "tiny:Ball", Related("sk:at", "a", "x")),
        Expression('`gripper_1.force` > "x"'),
        Expression("a > 1"),
    ],
    ids=_named,
)
def test_an_impossible_class_is_found_in_any_pattern(pattern: Pattern) -> None:
    assert broken(word(pattern)) == {"wrong-range"}


@pytest.mark.parametrize(
    "pattern",
    [
        Related("sk:at", "a", "b"),
        Related("sk:placement", "b", "a"),
        Compare("sk:mass", "<", "b", 1.5),
        Exists("x", "tiny:Ball", Compare("sk:missedLooks", ">", "x", 0.5)),
        Compare("sk:missing", "!=", "b", False),
        IsA("b", "tiny:Box"),
        Exists("x", "tiny:Slot", Related("sk:at", "a", "x")),
    ],
    ids=_named,
)
def test_a_possible_class_is_not_reported(pattern: Pattern) -> None:
    assert broken(word(pattern)) == set()


def test_a_superclass_of_the_required_class_is_not_reported() -> None:
    assert broken(word(Related("sk:at", "a", "b"), a="sk:SpatialThing", b="sk:Element")) == set()


def test_a_class_with_a_second_parent_may_be_both() -> None:
    assert broken(word(Related("sk:at", "a", "b"), b="sk:Furniture")) == set()  # a bench is a box, too


def test_an_argument_that_never_fits_its_role_is_reported() -> None:
    (finding,) = findings(replace(DRIVE, pre=(IN_CONTAINER("Robot", "Location"),)))

    assert finding.rule == "wrong-range"
    assert "its ball is a tiny:Ball, and Robot is a sk:Robot" in finding.text


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (Do.of("wave", arm=P("Base")), "'wave' takes a sk:Arm as arm, and Base is a sk:Base"),
        (Do.of("wave", arm=P("Speed")), "'wave' takes a sk:Arm as arm, and Speed is not an element"),
        (Do.of("pick", Ball=P("Location"), Box=P("Location")), "'pick' takes a tiny:Ball as Ball"),
        (ForEach("ball", "tiny:Ball", Do.of("pick", Box=P("ball"))), "'pick' takes a tiny:Box as Box, and ball is"),
    ],
)
def test_a_parameter_passed_with_an_impossible_class_is_reported(body: Behaviour, said: str) -> None:
    fast = replace(DRIVE, params=(*DRIVE.params, Param("Speed", "number", "How fast.", unit="m/s")))

    found = [f for f in findings(Skill(fast, body)) if f.rule == "wrong-range"]

    assert [said in finding.text for finding in found] == [True]


# ------------------------------------------------------------------------------------------ calls and parameters


def test_a_skill_may_call_a_skill_and_leave_its_elements_to_inference() -> None:
    assert of_body(Do.of("pick", Ball=P("Location"))) == {"wrong-range"}
    assert of_body(Do.of("pick")) == set()
    assert problems_of(Skill(DRIVE, Do.of("pick")), tiny_ontology(), {}, skills=SKILLS) == ()


def test_values_that_a_called_skill_needs_must_be_given() -> None:
    slow = pretend(replace(PICK, name="creep", params=(*PICK.params, Param("Speed", "number", "How.", unit="m/s"))))
    caller = Skill(DRIVE, Do.of("creep"))

    (finding,) = findings(caller, skills=[slow, caller])

    assert (finding.rule, finding.text) == ("missing-argument", "skill 'creep' needs Speed")


class Squeeze(Wave):
    """Squeezes."""

    name: ClassVar[str] = "squeeze"

    @dataclass(frozen=True, slots=True)
    class Params:
        force: float = param("number", "How hard.", unit="N")
        gripper: str = param("sk:Gripper", "The gripper.", kind=Kind.HARDWARE)
        robot: str = param("sk:Robot", "The robot.", kind=Kind.PLANNING)
        of: str | None = param("tiny:Ball", "What.", kind=Kind.OPTIONAL)
        rate: float = param("number", "How often.", kind=Kind.CONFIG, default=1.0, unit="Hz")


class Weigh(Wave):
    """Weighs."""

    name: ClassVar[str] = "weigh"
    outputs: ClassVar[tuple[Output, ...]] = (Output("mass", "number", "What it weighs.", "kg"),)


def test_a_value_is_read_only_from_a_declared_output_of_the_primitive() -> None:
    there = Known(tiny_ontology(), {"weigh": Weigh}, SKILLS, REASONERS)

    def found(call: Do) -> list[tuple[str, str]]:
        return [(f.rule, f.text) for f in check(pretend(PICK, call), there)]

    assert found(Do.of("weigh", mass=Out("known"))) == []
    assert found(Do.of("weigh", mas=Out("known"))) == [
        ("unknown-module", "primitive 'weigh' has no output mas; did you mean mass?; it has mass")
    ]
    assert [rule for rule, _ in found(Do.of("drive", mass=Out("known")))] == ["unknown-module"]


def test_an_output_needs_a_description_and_a_unit() -> None:
    bad = type("Bad", (Weigh,), {"__doc__": "Weighs.", "outputs": (Output("mass", "number", ""),)})

    assert broken(Weigh) == set()
    assert broken(bad) == {"missing-help", "missing-unit"}


def of_call(call: Do) -> list[tuple[str, str]]:
    there = Known(tiny_ontology(), {"squeeze": Squeeze}, SKILLS, REASONERS)
    return [(f.rule, f.text) for f in check(pretend(PICK, call), there, rules=RULES.values())]


def test_inferable_parameters_may_be_omitted_in_a_call_of_a_primitive() -> None:
    assert of_call(Do.of("squeeze", force=3.0)) == []
    assert of_call(Do.of("squeeze")) == [("missing-argument", "primitive 'squeeze' needs force")]


def test_parameters_fixed_at_loading_cannot_be_passed() -> None:
    ((rule, text),) = of_call(Do.of("squeeze", force=3.0, rate=2.0))

    assert (rule, text) == (
        "unknown-module",
        "primitive 'squeeze' has rate fixed when it is loaded: it cannot be given at a call",
    )


@pytest.mark.parametrize("driver", [None, "pybullet"])
def test_a_skill_for_real_robots_must_not_assert_unsensed_effects_anywhere(driver: str | None) -> None:
    (problem,) = problems_of(Skill(DRIVE, Fallback.of(AssertEffects()), driver=driver), tiny_ontology(), {})

    assert "only skills for driver 'fake' may" in problem
    assert problems_of(Skill(DRIVE, Do.of("drive"), finish=AssertEffects()), tiny_ontology(), {}, skills=SKILLS)


def test_a_misspelt_parameter_of_a_module_is_reported_with_the_most_similar_one() -> None:
    texts = [f.text for f in findings(Skill(DRIVE, Do.of("pick", Bal=P("Location"))))]

    assert texts == ["skill 'pick' has no parameter Bal; did you mean Ball?"]


def test_an_asserted_effect_that_is_not_a_postcondition_is_found() -> None:
    assert broken(pretend(DRIVE, AssertEffects(1.0, ("nothing",)))) == {"missing-parameter"}


def test_a_loop_variable_needs_a_distinct_name() -> None:
    query = AllOf((Related("sk:on", "x", "Location"), Not(Related("sk:at", "Robot", "x"))))

    assert of_body(ForEach("x", "tiny:Box", Do.of("pick", Box=P("x")), query)) == set()


def test_a_primitive_takes_what_is_among_its_parameters() -> None:
    class Grab(Wave):
        """Grabs."""

        takes: ClassVar[tuple[str, ...]] = ("robot",)

    assert broken(Grab) == {"missing-parameter"}


# ------------------------------------------------------------------------------------------ reach


def needs(*pre: Condition, skill: Skill | None = None) -> set[str]:
    description = replace(PLACE, name="stow", pre=(*pre,))
    return broken(description, skills=[pretend(description), *([skill] if skill else [])])


def test_preconditions_that_place_one_thing_twice_are_found() -> None:
    assert needs(HOLDING("Gripper", "Ball"), IN_CONTAINER("Ball", "Slot")) == {"unreachable-precondition"}
    assert needs(HOLDING("Gripper", "Ball"), ~IN_CONTAINER("Ball", "Slot")) == set()
    assert needs(any_of(HOLDING("Gripper", "Ball"), CONDITIONS["Free"]("Slot")), IN_CONTAINER("Ball", "Slot")) == set()


def test_preconditions_that_want_a_place_empty_and_filled_are_found() -> None:
    assert needs(CONDITIONS["Free"]("Slot"), IN_CONTAINER("Ball", "Slot")) == {"unreachable-precondition"}
    assert needs(CONDITIONS["Free"]("Slot"), ~CONDITIONS["Free"]("Slot")) == {"unreachable-precondition"}


def test_relations_that_skills_only_remove_are_found_unless_one_restores_them() -> None:
    knows = ConditionType(
        "Knows", (Role("a", "sk:Robot"), Role("b", "sk:Location")), Related("tiny:knows", "a", "b"), "Knows it."
    )
    forget = pretend(replace(DRIVE, name="forget", post=(~knows("Robot", "Location"),)))
    learn = pretend(replace(DRIVE, name="learn", post=(knows("Robot", "Location"),)))
    use = replace(DRIVE, name="use", pre=(knows("Robot", "Location"),))

    assert broken(use, skills=[]) == set()
    assert broken(use, skills=[forget]) == {"unreachable-precondition"}
    assert broken(use, skills=[forget, learn]) == set()


def test_values_that_skills_only_remove_are_found() -> None:
    def lost(value: bool) -> ConditionType:
        return ConditionType("Is", (Role("b", "sk:Location"),), Compare("sk:missing", "=", "b", value), "Is it?")

    lose = pretend(replace(DRIVE, name="lose", post=(lost(True)("Location"),)))
    find = pretend(replace(DRIVE, name="find", post=(lost(False)("Location"),)))
    use = replace(DRIVE, name="use", pre=(lost(False)("Location"),))

    assert broken(use, skills=[lose]) == {"unreachable-precondition"}
    assert broken(use, skills=[lose, find]) == set()


# ------------------------------------------------------------------------------------------ composition


@pytest.mark.parametrize(
    ("body", "is_endless"),
    [
        (Do.of("drive"), True),
        (Sequence.of(Do.of("wave", arm="x"), Retry(Do.of("drive"), 3)), True),
        (Fallback.of(Do.of("drive"), Do.of("pick")), False),
        (ForEach("x", "tiny:Box", Do.of("drive")), False),
        (Parallel.of(Do.of("drive"), Do.of("wave", arm="x")), True),
        (Parallel.of(Do.of("drive"), Do.of("wave", arm="x"), policy=Policy.FIRST_SUCCESS), False),
    ],
)
def test_only_a_skill_that_must_call_itself_is_reported_as_recursive(body: Behaviour, is_endless: bool) -> None:
    assert ("recursive-skill" in of_body(body)) is is_endless


def test_skills_that_call_each_other_in_a_cycle_are_reported_as_recursive() -> None:
    there, back = Skill(DRIVE, Do.of("back")), Skill(replace(DRIVE, name="back"), Do.of("drive"))

    assert broken(there, back, skills=[there, back]) == {"recursive-skill"}


def test_a_call_cycle_with_a_terminating_implementation_is_accepted() -> None:
    there, back = Skill(DRIVE, Do.of("back")), Skill(replace(DRIVE, name="back"), Do.of("drive"))
    direct = Skill(DRIVE, Do.of("wave", arm="x"), label="direct")

    assert broken(there, back, direct, skills=[there, back, direct]) == set()


def test_parallel_branches_may_claim_different_devices() -> None:
    arms = (Param("Left", "sk:Arm", "One.", Kind.HARDWARE), Param("Right", "sk:Arm", "Other.", Kind.HARDWARE))
    two = replace(DRIVE, params=(*DRIVE.params, *arms))
    waving = [Do.of("wave", arm=P(key)) for key in ("Left", "Right", "Left")]

    assert broken(Skill(two, Parallel.of(*waving[:2]))) == set()
    (finding,) = findings(Skill(two, Parallel.of(*waving)))
    assert finding.text.startswith("parallel branches 1 and 3 both take Left")


@pytest.mark.parametrize(
    ("branches", "said"),
    [
        ((Do.of("wave"), Do.of("wave")), "the robot's sk:Arm"),
        ((Do.of("wave"), Do.of("pick")), "the robot's sk:Arm"),
        ((Do.of("drive"), Do.of("drive")), "Base"),
        ((Do.of("drive", Base=P("Base")), Sequence.of(Do.of("wave"), Do.of("drive"))), "Base"),
        ((Do.of("wave", arm="arm_1"), Do.of("wave")), "arm_1"),
        ((Do.of("drive"), Do.of("wave")), ""),
        ((Do.of("wave", arm="arm_1"), Do.of("wave", arm="arm_2")), ""),
    ],
)
def test_omitted_devices_are_those_of_the_robot(branches: tuple[Behaviour, ...], said: str) -> None:
    texts = [f.text for f in findings(pretend(replace(DRIVE, name="roam"), Parallel.of(*branches)))]

    assert [f"both take {said} exclusively:" in text for text in texts] == [True] * bool(said)


@pytest.mark.parametrize(
    ("one", "other", "refused"),
    [
        (Access.SHARED, Access.SHARED, False),
        (Access.SHARED, Access.EXCLUSIVE, True),
        (Access.READ, Access.EXCLUSIVE, False),
    ],
)
def test_parallel_branches_may_use_one_device_if_both_share_it_or_one_only_reads(
    one: Access, other: Access, refused: bool
) -> None:
    def waving(access: Access) -> type[Wave]:
        class Other(Wave):
            """Waves."""

            @dataclass(frozen=True, slots=True)
            class Params:
                arm: str = param("sk:Arm", "The arm.", kind=Kind.HARDWARE, access=access)

        return Other

    there = Known(tiny_ontology(), {"a": waving(one), "b": waving(other)}, SKILLS, REASONERS)
    roam = pretend(replace(DRIVE, name="roam"), Parallel.of(Do.of("a"), Do.of("b")))

    assert [f.rule for f in check(roam, there, rules=[RULES["same-device"]])] == ["same-device"] * refused


def test_read_access_claims_nothing() -> None:
    class Watch(Wave):
        """Looks on."""

        watches: ClassVar[str] = "sk:Arm"

    there = Known(tiny_ontology(), {"wave": Watch}, SKILLS, REASONERS)
    roam = pretend(replace(DRIVE, name="roam"), Parallel.of(Do.of("wave"), Do.of("wave")))

    assert list(check(roam, there, rules=[RULES["same-device"]])) == []


# ------------------------------------------------------------------------------------------ code


def source(text: str, *, primitives: bool = True, **names: Any) -> Source:
    return Source(Path("home.py"), text, names, primitives)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("def f(self):\n    try:\n        yield\n    finally:\n        yield\n", 5),
        ("def f(self):\n    try:\n        yield\n    finally:\n        if self.x:\n            yield from g()\n", 6),
        ("def f(self):\n    try:\n        yield\n    finally:\n        base.command(STOP)\n", 5),
        ("def f(self):\n    try:\n        yield\n    except GeneratorExit:\n        self.call('home')\n", 5),
        ("def f(self):\n    try:\n        yield\n    except BaseException:\n        yield\n        raise\n", 5),
    ],
)
def test_motion_in_the_cleanup_of_a_primitive_is_found(text: str, line: int) -> None:
    (finding,) = findings(source(text))

    assert finding.rule == "motion-in-finally"
    assert str(finding).startswith(f"home.py:{line}: motion-in-finally: home.py: ")


@pytest.mark.parametrize(
    "text",
    [
        "def f(self):\n    try:\n        yield\n    finally:\n        self.gripper.halt()\n",
        "def f(self):\n    try:\n        yield\n    except ValueError:\n        yield\n",
        "def f(self):\n    try:\n        pass\n    finally:\n        def g():\n            yield\n",
        "def f(self):\n    try:\n        pass\n    finally:\n        self.calls.clear()\n",
    ],
)
def test_releasing_things_in_the_cleanup_of_a_primitive_is_accepted(text: str) -> None:
    assert broken(source(text)) == set()


@pytest.mark.parametrize(
    "text",
    [
        "import time\ntime.sleep(1)\n",
        "from time import sleep\nsleep(1)\n",
        "from time import sleep as nap\nnap(1)\n",
        "import subprocess as s\ns.run(['ls'])\n",
        "import requests\nrequests.get('x')\n",
        "import urllib.request\nurllib.request.urlopen('x')\n",
        "answer = input()\n",
    ],
)
def test_blocking_calls_are_found_however_they_are_imported(text: str) -> None:
    assert broken(source(text)) == {"blocking-call"}


def test_blocking_calls_are_accepted_outside_primitives_and_where_allowed() -> None:
    text = "import time\ntime.sleep(1)  # skiros: allow blocking-call\nclock.sleep(1)\ntime.time()\n"

    assert broken(source("import time\ntime.sleep(1)\n", primitives=False)) == set()
    assert broken(source(text)) == set()
    assert broken(source(text.replace("blocking-call", "unknown-word"))) == {"blocking-call"}


@pytest.mark.parametrize(
    ("text", "is_private"),
    [
        ("from skiros_py.execution.cycle import ControlCycle\n", True),
        ("import skiros_py.station.session\n", True),
        ("from skiros_py import station\n", True),
        ("from skiros_py import Session\n", False),
        ("from skiros_py.skills.skill import Skill\n", False),
        ("from skiros_py.planning.planners.planner import Answer\n", False),
        ("from skiros_py.recording import Recorder, Schema, Topic\n", False),
        ("from skiros_py.recording.topic import own_schema\n", True),
        ("from skiros_primitives.grasp import Grasp\n", False),
        ("from .execution import x\n", False),
    ],
)
def test_imports_of_internal_modules_are_found(text: str, is_private: bool) -> None:
    assert broken(source(text)) == ({"private-import"} if is_private else set())


@pytest.mark.parametrize(
    ("text", "is_found"),
    [
        ("tx.relate(box, 'sk:hasA', part)\n", True),
        ("tx.unrelate(box, HAS_A, part)\n", True),
        ("tx.relate(box, words.HAS_A, part)\n", True),
        ("tx.relate(box, 'sk:startLocation', part)\n", False),
        ("view.related(box, 'sk:hasA', part)\n", False),
    ],
)
def test_code_that_moves_things_by_structural_relations_is_found(text: str, is_found: bool) -> None:
    class Words:
        HAS_A = "sk:hasA"

    assert broken(source(text, HAS_A="sk:hasA", words=Words)) == ({"moves-by-structure"} if is_found else set())


def test_execute_may_return_the_generator_of_another_method() -> None:
    class Handing(Wave):
        """Hands on."""

        def execute(self) -> Execution[Outcome]:
            return self._wave()

        def _wave(self) -> Execution[Outcome]:
            yield
            return Success()

    assert broken(Handing) == set()


def test_generated_and_inherited_docstrings_do_not_count_as_documentation() -> None:
    class Silent(Wave):
        pass

    assert broken(Silent) == {"missing-help"}


def test_an_object_that_raises_during_inspection_is_a_finding() -> None:
    class Odd:
        def rename(self, names: object) -> Pattern:
            raise RuntimeError("not today")

    texts = {finding.text for finding in findings(word(Odd()))}  # type: ignore[arg-type]

    assert "it cannot be inspected: RuntimeError: not today" in texts


# ------------------------------------------------------------------------------------------ held against the world


def _one_of_each() -> World:
    """A world with an element of every class that there may be elements of, under the class's name."""
    world = tiny_world()
    classes = [c for c in world.ontology.subclasses("sk:Element") if c not in ("sk:Root", "sk:Scene")]
    with world.transaction("test", "one of each") as tx:
        for class_ in classes:
            floor = Placement("sk:on", "floor") if world.ontology.is_a(class_, "sk:SpatialThing") else None
            is_root = world.ontology.is_a(class_, "sk:Root")
            tx.add(class_, id=class_.replace(":", "_"), placement=None if is_root else floor)
    return world


EACH = _one_of_each()
CLASSES = sorted({EACH.element(name).type for name in EACH.instances("sk:Element")})
STORED = sorted(r.curie for r in EACH.ontology.relations.values() if r.family is not Family.COMPUTED)


@given(st.sampled_from(STORED), st.sampled_from(CLASSES), st.sampled_from(CLASSES))
@settings(max_examples=200, deadline=None)
def test_a_range_is_reported_exactly_if_the_world_refuses_all_elements_of_the_classes(
    relation: str, subject: str, object_: str
) -> None:
    index, ontology = EACH.snapshot(), EACH.ontology
    allowed = any(
        relation_problem(index, f"{one.replace(':', '_')}", below, f"{other.replace(':', '_')}") is None
        for below in ontology.sub_relations(relation)
        for one in ontology.subclasses(subject)
        for other in ontology.subclasses(object_)
        if index.has(one.replace(":", "_")) and index.has(other.replace(":", "_"))
    )

    pattern = Related(relation, "a", "b")

    found = list(check(word(pattern, a=subject, b=object_), known(), rules=[RULES["wrong-range"]]))

    assert (found == []) is allowed


def test_device_kinds_are_looked_up_only_for_skills_that_share_devices(monkeypatch: pytest.MonkeyPatch) -> None:
    looked_up: list[str] = []
    monkeypatch.setattr("skiros_py.skills.lint.rules.devices.load_device_kinds", lambda: looked_up.append("kinds"))

    assert problems_of(Skill(DRIVE, Do.of("pick")), tiny_ontology(), {}, skills=SKILLS) == ()
    assert looked_up == []
