"""Templates are filled in on the data: a name stays a name, and nothing that was ordered is passed over."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.api.goals import GoalTemplateContent, Material
from skiros_py.errors import UnknownName, UsageError
from skiros_py.station.jobs.template_document import faults_of, filled

KIT = GoalTemplateContent.model_validate(
    {
        "parameters": [{"name": "kit", "class": "Kit"}, {"name": "robot", "default": "robot_1"}],
        "goal": [{"not": {"condition": "At", "arguments": [{"parameter": "robot"}, {"parameter": "kit"}]}}],
        "per_material": {"condition": "In", "arguments": [{"material": "class"}, {"material": "location"}]},
    }
)


def material(class_="Starter", **fields):
    return Material.model_validate({"class": class_, "location": "kit_1_a", **fields})


@given(st.text(min_size=1), st.text(min_size=1))
def test_names_with_special_characters_are_inserted_unchanged(kit, class_):
    values = {"kit": kit}
    plain = Material.model_construct(class_=class_, quantity=1, id="", location="x", use="")
    goal, piece = filled("fill", KIT, values, (plain,))
    assert goal == {"not": {"condition": "At", "arguments": ["robot_1", kit]}}
    assert piece == {"condition": "In", "arguments": [class_, "x"]}


def test_each_piece_of_the_material_gets_its_condition():
    ordered = (material(location="a"), material("Alternator", location="b"), material(location="c"))
    _, *pieces = filled("fill", KIT, {"kit": "kit_1"}, ordered)
    assert [piece["arguments"] for piece in pieces] == [["Starter", "a"], ["Alternator", "b"], ["Starter", "c"]]


def test_two_pieces_with_the_same_condition_are_refused():
    with pytest.raises(UsageError, match="two pieces lead to the same condition"):
        filled("fill", KIT, {"kit": "kit_1"}, (material(quantity=2),))


def test_a_class_is_the_same_with_and_without_its_prefix():
    with pytest.raises(UsageError, match="two pieces lead to the same condition"):
        filled("fill", KIT, {"kit": "kit_1"}, (material("Starter"), material("kitting:Starter")))


def test_an_order_without_materials_is_refused_by_a_template_per_material():
    with pytest.raises(UsageError, match="none is ordered"):
        filled("fill", KIT, {"kit": "kit_1"}, ())


def test_a_parameter_that_is_missing_or_unknown_is_named():
    with pytest.raises(UsageError, match="'fill' needs kit"):
        filled("fill", KIT, {}, (material(),))
    with pytest.raises(UnknownName, match=r"unknown parameter 'kitt' of goal template 'fill'\. Did you mean 'kit'"):
        filled("fill", KIT, {"kitt": "kit_1"}, (material(),))


def test_a_field_of_the_material_that_is_needed_must_be_there():
    with pytest.raises(UsageError, match="needs the location of each material"):
        filled("fill", KIT, {"kit": "kit_1"}, (material(location=""),))


def test_material_for_a_template_without_materials_is_refused():
    bare = KIT.model_copy(update={"per_material": None})
    with pytest.raises(UsageError, match="says nothing of materials"):
        filled("fill", bare, {"kit": "kit_1"}, (material(),))


def test_a_template_with_only_material_conditions_needs_material():
    alone = KIT.model_copy(update={"goal": ()})
    with pytest.raises(UsageError, match="none is ordered"):
        filled("fill", alone, {"kit": "kit_1"}, ())


def test_an_order_for_more_than_2000_pieces_is_refused():
    with pytest.raises(UsageError, match="more than 2000 pieces"):
        filled("fill", KIT, {"kit": "kit_1"}, (material(quantity=1000),) * 3)


def test_a_template_that_would_make_too_much_of_an_order_is_refused_before_it_makes_anything():
    atom = {"condition": "In", "arguments": [{"material": "class"}, {"material": "location"}]}
    large = KIT.model_copy(update={"per_material": {"all_of": [atom] * 500}})
    with pytest.raises(UsageError, match="'fill' is too large for 6 pieces in one order; for 5 it will do"):
        filled("fill", large, {"kit": "kit_1"}, tuple(material(location=f"place {n}") for n in range(6)))


def test_a_template_has_a_greatest_size():
    (fault,) = faults_of(GoalTemplateContent.model_validate({"per_material": {"all_of": [{"a": ["x"]}] * 2000}}))
    assert "at most 5000 names, lists and objects, not 60" in str(fault)


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({}, "goal: a template needs conditions"),
        ({"goal": [{"a": [{"parameter": "kot"}]}]}, "goal[0].a[0]: unknown parameter 'kot'. Did you mean 'kit'?"),
        ({"goal": [{"a": {"material": "class"}}]}, "goal[0].a: unknown field of a material 'class'"),
        ({"per_material": {"a": {"material": "clas"}}}, "per_material.a: unknown field of a material 'clas'"),
    ],
)
def test_a_fault_in_placeholders_is_reported_with_its_path(fields, said):
    content = GoalTemplateContent.model_validate({"parameters": [{"name": "kit"}], **fields})
    assert any(said in str(fault) for fault in faults_of(content))


def test_a_parameter_that_is_there_twice_is_named():
    content = GoalTemplateContent.model_validate({"parameters": [{"name": "kit"}] * 2, "goal": [{"a": 1}]})
    assert [str(fault) for fault in faults_of(content)] == ["parameters: 'kit' is there twice"]
