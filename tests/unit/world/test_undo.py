"""Undo, whatever keeps the changes: a list in memory, or a journal that was closed and opened again in between."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from skiros_py.errors import StaleVersion, WorldError
from skiros_py.testing import tiny_ontology, tiny_scene
from skiros_py.world.change import Change, GoalsEdit, Writer
from skiros_py.world.element import Placement
from skiros_py.world.journal.data_directory import DataDirectory
from skiros_py.world.scene.files import load_scene
from skiros_py.world.transaction import Transaction
from skiros_py.world.undo import redo, undo
from skiros_py.world.world import World

Edit = Callable[[Transaction], object]


class Case:
    """A world; :meth:`again` gives the same one after whatever may happen between two edits."""

    def __init__(self, world: World, again: Callable[[], World]) -> None:
        self._world = world
        self._again = again

    def again(self) -> World:
        self._world = self._again()
        return self._world

    def write(self, edit: Edit, *, author: str = "ann", writer: Writer = Writer.PERSON) -> Change:
        with self.again().transaction(author, "because", writer=writer) as tx:
            edit(tx)
        return self._world.changes_since(self._world.version - 1)[0]

    def undo(self) -> Change:
        return undo(self.again(), "bob")

    def refusal(self) -> str:
        world = self.again()
        before = world.version
        with pytest.raises(WorldError) as caught:
            undo(world, "bob")
        assert world.version == before
        return str(caught.value)


@pytest.fixture(params=["memory", "journal", "journal opened again", "journal compacted"])
def case(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Case]:
    scene = tiny_scene(tmp_path)
    if request.param == "memory":
        world = load_scene(tiny_ontology(), scene)
        yield Case(world, lambda: world)
        return
    data = [DataDirectory.open(tmp_path / "data", tiny_ontology(), scene=scene)]

    def again() -> World:
        if request.param == "journal compacted":
            data[0].compact(keep=100)
        if request.param != "journal":
            data[0].close()
            data[0] = DataDirectory.open(tmp_path / "data", tiny_ontology())
        return data[0].world

    yield Case(data[0].world, again)
    data[0].close()


def heavier(mass: float, element: str = "ball_1") -> Edit:
    return lambda tx: tx.set(element, "sk:mass", mass)


def test_undo_reverts_the_last_edit_by_a_person_as_a_new_change(case: Case) -> None:
    case.write(heavier(1.0))
    edit = case.write(heavier(2.0))

    change = case.undo()

    assert (change.undoes, change.author, change.writer) == (edit.number, "bob", Writer.PERSON)
    assert change.reason == f"undoes change {edit.number}: because"
    assert case.again().value("ball_1", "sk:mass") == 1.0


def test_a_second_undo_reverts_the_previous_edit(case: Case) -> None:
    case.write(heavier(1.0))
    case.write(heavier(2.0))

    case.undo()
    case.undo()

    assert case.again().value("ball_1", "sk:mass") is None
    assert "nothing to undo" in case.refusal()


def mass(case: Case) -> object:
    return case.again().value("ball_1", "sk:mass")


def test_undone_edits_are_redone_one_by_one_and_can_be_undone_again(case: Case) -> None:
    case.write(heavier(1.0))
    case.write(heavier(2.0))
    case.undo()
    case.undo()

    redo(case.again(), "bob")
    assert mass(case) == 1.0
    redo(case.again(), "bob")
    assert mass(case) == 2.0
    with pytest.raises(WorldError, match="nothing to redo"):
        redo(case.again(), "bob")

    case.undo()
    assert mass(case) == 1.0
    redo(case.again(), "bob")
    assert mass(case) == 2.0


def test_a_removed_element_that_was_restored_is_removed_again_by_a_redo(case: Case) -> None:
    case.write(lambda tx: tx.add("tiny:Box", id="box_c", placement=Placement("sk:on", "floor")))
    case.undo()
    redo(case.again(), "bob")
    assert case.again().has("box_c")
    case.undo()
    assert not case.again().has("box_c")


def test_after_another_edit_by_a_person_nothing_is_redone(case: Case) -> None:
    case.write(heavier(1.0))
    case.undo()
    case.write(heavier(3.0))
    with pytest.raises(WorldError, match="nothing to redo"):
        redo(case.again(), "bob")
    assert mass(case) == 3.0


def test_a_redo_never_overwrites_what_a_skill_has_sensed_since(case: Case) -> None:
    case.write(heavier(1.0))
    case.undo()
    case.write(heavier(5.0), writer=Writer.SKILL)
    with pytest.raises(WorldError, match="ball_1"):
        redo(case.again(), "bob")
    assert mass(case) == 5.0


def test_undo_never_reverts_edits_by_skills_jobs_or_the_platform(case: Case) -> None:
    for writer in (Writer.SKILL, Writer.JOB, Writer.SYSTEM):
        case.write(heavier(len(writer)), writer=writer)

    assert "no edit by a person" in case.refusal()


def test_undoing_an_addition_is_refused_while_the_element_has_content(case: Case) -> None:
    case.write(lambda tx: tx.add("tiny:Box", id="box_c", placement=Placement("sk:on", "floor")))
    case.write(lambda tx: tx.place("ball_1", "sk:in", "box_c"), author="place", writer=Writer.SKILL)

    assert "ball_1 (tiny:Ball) is nowhere" in case.refusal()
    assert case.again().placement("ball_1") == Placement("sk:in", "box_c")


def test_undo_is_refused_when_a_later_change_touched_the_same_element(case: Case) -> None:
    edit = case.write(heavier(1.0))
    case.write(heavier(2.0), author="weigh", writer=Writer.SKILL)

    assert case.refusal() == (
        f"change {edit.number} (ann: because) cannot be undone: ball_1 changed since, by weigh (because)"
    )


def test_undo_is_possible_after_later_changes_of_other_elements(case: Case) -> None:
    case.write(heavier(1.0))
    case.write(heavier(2.0, "red_ball_1"), author="weigh", writer=Writer.SKILL)

    case.undo()

    assert case.again().value("ball_1", "sk:mass") is None


def test_undoing_a_change_of_goals_is_refused_after_a_later_change_of_goals(case: Case) -> None:
    before = case.again().goals
    case.write(lambda tx: tx.set_goals(["In(ball_1, slot_1)"]))
    case.undo()

    assert case.again().goals == before

    case.write(lambda tx: tx.set_goals(["In(ball_1, slot_1)"]))
    case.write(lambda tx: tx.set_goals(["In(ball_1, slot_2)"]), author="job", writer=Writer.JOB)

    assert "the goals changed since, by job" in case.refusal()


def test_undoing_a_removal_restores_the_element_with_its_parts_and_relations(case: Case) -> None:
    case.write(lambda tx: (tx.set("ball_1", "sk:mass", 1.5), tx.set("ball_1", "rdfs:label", "mine")))
    state = facts(case.again())
    case.write(lambda tx: tx.remove("box_a"))

    case.undo()

    assert facts(case.again()) == state


def test_undoing_a_learned_concept_removes_it_and_its_id_is_not_reused(case: Case) -> None:
    case.write(lambda tx: tx.add("tiny:Ball", "mug", learned=True))
    case.undo()
    assert not case.again().has("learned:ball_1")

    ids: list[str] = []
    case.write(lambda tx: ids.append(tx.add("tiny:Ball", "cup", learned=True)))

    assert ids == ["learned:ball_2"]


def test_the_next_undoable_edit_can_be_read(case: Case) -> None:
    assert case.again().log.undoable() is None
    first = case.write(heavier(1.0))
    second = case.write(lambda tx: tx.set_goals(["In(ball_1, slot_1)"]))

    assert case.again().log.undoable() == second
    assert isinstance(second.edits[0], GoalsEdit)
    case.undo()
    assert case.again().log.undoable() == first


def facts(world: World) -> object:
    state = world.snapshot()
    elements = {name: state.element(name) for name in state.ids()}
    return elements, list(state.statements()), state.goals


def test_undo_is_refused_if_the_undoable_change_is_not_the_expected_one(tmp_path: Path) -> None:
    world = load_scene(tiny_ontology(), tiny_scene(tmp_path))
    for label in ("one", "two"):
        with world.transaction("ann", label, writer=Writer.PERSON) as tx:
            tx.set("ball_1", "rdfs:label", label)

    with pytest.raises(StaleVersion, match=r"change 2 is not the one that can be undone now, which is change 3 \(ann"):
        undo(world, "bob", expects=2)

    assert undo(world, "bob", expects=3).undoes == 3
