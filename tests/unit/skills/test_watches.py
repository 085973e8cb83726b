from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.errors import UnknownName, WorldError
from skiros_py.geometry import Pose
from skiros_py.skills.conditions import (
    AllOf,
    Compare,
    Computed,
    Condition,
    ConditionType,
    Exists,
    Expression,
    Has,
    IsA,
    Not,
    Pattern,
    Related,
    Role,
    Verdict,
    any_of,
)
from skiros_py.skills.conditions.watch import Watches
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import AT_LOCATION, EMPTY_HANDED, FREE, HOLDING, IN_CONTAINER, REACHABLE
from skiros_py.world.view import NoSensors
from skiros_py.world.world import World


def word(pattern: Pattern, *arguments: str) -> Condition:
    roles = tuple(Role(name, "sk:Element") for name in ("a", "b")[: len(arguments)])
    return ConditionType("Word", roles, pattern, "-")(*arguments)


def afresh(world: World, conditions: Sequence[Condition]) -> Verdict | None:
    return next((verdict for c in conditions if not (verdict := c.evaluate(world))), None)


@contextmanager
def counted(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """Notes each condition that is really evaluated."""
    evaluated: list[str] = []
    original = Condition.evaluate

    def evaluate(self: Condition, *args: object) -> Verdict:
        evaluated.append(str(self))
        return original(self, *args)  # type: ignore[arg-type]

    with monkeypatch.context() as patch:
        patch.setattr(Condition, "evaluate", evaluate)
        yield evaluated


def test_a_watch_reports_when_a_condition_breaks_and_when_it_holds_again() -> None:
    world = tiny_world()
    watch = Watches(world).add([IN_CONTAINER("Ball", "box_a"), EMPTY_HANDED("gripper_1")], {"Ball": "ball_1"})
    assert watch.broken() is None

    with world.transaction("test", "taken") as tx:
        tx.place("ball_1", "sk:heldBy", "gripper_1")
    broken = watch.broken()
    assert broken is not None
    assert broken.text == "In(ball_1, box_a)"

    with world.transaction("test", "put back") as tx:
        tx.place("ball_1", "sk:in", "box_a")
    assert watch.broken() is None


def test_a_watch_evaluates_again_only_after_a_change_of_what_it_read(monkeypatch: pytest.MonkeyPatch) -> None:
    world = tiny_world()
    watch = Watches(world).add([IN_CONTAINER("ball_1", "box_a"), FREE("slot_1"), REACHABLE("box_a")])
    watch.broken()

    with counted(monkeypatch) as evaluated:
        watch.broken()
        for step in range(3):
            with world.transaction("test", "unrelated") as tx:
                tx.set("robot_1", "sk:pose", Pose.of(step, 0.0, 0.0))
                tx.place("red_ball_1", "sk:in", "slot_2" if step % 2 else "box_a")
            watch.broken()
        assert evaluated == []
        with world.transaction("test", "related") as tx:
            tx.place("red_ball_1", "sk:in", "slot_1")
        assert watch.broken() is not None
        assert evaluated == ["Free(slot_1)"], "only the one that read it"


def test_a_watch_notices_changes_of_what_a_reasoner_read() -> None:
    world = tiny_world()
    with world.transaction("test", "poses") as tx:
        for thing, x in (("ball_1", 0.0), ("box_a", 0.3)):
            tx.set(thing, "sk:pose", Pose.of(x, 0.0, 0.0))
    watch = Watches(world).add([word(Computed("sk:near", "a", "b"), "ball_1", "box_a")])
    assert watch.broken() is None

    with world.transaction("test", "moved") as tx:
        tx.set("box_a", "sk:pose", Pose.of(3.0, 0.0, 0.0))

    assert watch.broken() is not None


def test_a_watch_notices_a_removed_element() -> None:
    world = tiny_world()
    watch = Watches(world).add([word(IsA("a", "tiny:Ball"), "ball_1")])
    assert watch.broken() is None

    with world.transaction("test", "lost") as tx:
        tx.remove("ball_1")

    broken = watch.broken()
    assert broken is not None
    assert broken.lines()[-1].strip() == "there is no ball_1"


def test_a_watch_notices_values_taught_for_a_class() -> None:
    world = tiny_world()
    watch = Watches(world).add([REACHABLE("slot_1")])
    assert watch.broken() is not None

    with world.transaction("test", "taught") as tx:
        pose = Pose.of(1.0, 0.0, 0.0)
        tx.add("sk:TaughtDrivingPose", properties={"sk:appliesTo": "tiny:Slot", "sk:drivingPose": pose}, learned=True)

    assert watch.broken() is None


class _Said(NoSensors):
    """Signals that a test sets."""

    def __init__(self) -> None:
        self.gap = 0.04

    def value(self, name: str) -> float | None:
        return self.gap if name == "gripper_1.gap" else None


def test_only_sensor_conditions_are_evaluated_each_time(monkeypatch: pytest.MonkeyPatch) -> None:
    world, said = tiny_world(), _Said()
    world.sensors = said
    wide = word(Expression("a.gap > 0.03"), "gripper_1")
    watch = Watches(world).add([wide, FREE("slot_1")])
    assert watch.broken() is None

    said.gap = 0.01
    with counted(monkeypatch) as evaluated:
        broken = watch.broken()

    assert broken is not None
    assert broken.lines()[-1].strip() == "gripper_1.gap is 0.01, not gripper_1.gap > 0.03"
    assert evaluated == ["Word(gripper_1)"]


def test_a_condition_that_cannot_be_evaluated_raises_each_time() -> None:
    watch = Watches(tiny_world()).add([word(Related("sk:inn", "a", "b"), "ball_1", "box_a")])

    for _ in range(2):
        with pytest.raises(UnknownName, match="sk:inn"):
            watch.broken()


def test_a_closed_watch_leaves_nothing_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    world = tiny_world()
    watches = Watches(world)
    watch, other = watches.add([FREE("slot_1")]), watches.add([FREE("slot_1")])
    watch.broken()
    other.broken()

    watch.close()
    with counted(monkeypatch) as evaluated, world.transaction("test", "filled") as tx:
        tx.place("ball_1", "sk:in", "slot_1")
    assert watch.broken() is None
    assert other.broken() is not None
    other.close()

    assert evaluated == []
    assert watches._readers == {}


def test_changes_by_another_thread_during_an_evaluation_are_not_missed() -> None:
    world = tiny_world()
    watch = Watches(world).add([FREE("slot_1"), IN_CONTAINER("ball_1", "box_a")])
    over = threading.Event()

    def write() -> None:
        for step in range(300):
            with world.transaction("other", "moves") as tx:
                tx.place("ball_1", "sk:in", "slot_1" if step % 2 == 0 else "box_a")
        over.set()

    thread = threading.Thread(target=write)
    thread.start()
    while not over.is_set():
        watch.broken()
    thread.join()

    assert watch.broken() == afresh(world, [FREE("slot_1"), IN_CONTAINER("ball_1", "box_a")])


BALLS = ("ball_1", "red_ball_1", "ball_9")
PLACES = ("box_a", "box_b", "slot_1", "slot_2")
SOME_IN = Exists("ball", "tiny:Ball", AllOf((Related("sk:in", "ball", "a"), Has("tiny:scanned", "ball"))))
CONDITIONS: tuple[Condition, ...] = (
    *(IN_CONTAINER(ball, place) for ball in BALLS for place in PLACES[:3]),
    *(~IN_CONTAINER("tiny:RedBall", place) for place in PLACES),
    *(FREE(slot) for slot in PLACES[2:]),
    EMPTY_HANDED("gripper_1"),
    ~EMPTY_HANDED("gripper_1"),
    AT_LOCATION("robot_1", "box_a"),
    any_of(HOLDING("gripper_1", "ball_1"), AT_LOCATION("robot_1", "box_b")),
    *(word(SOME_IN, place) for place in PLACES),
    *(word(Compare("tiny:scanned", "=", "a", True), ball) for ball in BALLS),
    *(word(Not(Has("tiny:scanned", "a")), ball) for ball in BALLS),
    word(Related("sk:placement", "a", "b"), "ball_1", "slot_1"),
    word(Related("tiny:knows", "a", "b"), "robot_1", "box_a"),
    *(word(Computed("sk:near", "a", "b"), "ball_1", place) for place in PLACES[:2]),
    *(word(Exists("c", "sk:Location", Computed("sk:near", "a", "c")), ball) for ball in BALLS),
    word(IsA("a", "tiny:RedBall"), "ball_9"),
    REACHABLE("slot_1"),
)
edits = st.one_of(
    st.tuples(st.just("place"), st.sampled_from(BALLS), st.just("sk:in"), st.sampled_from(PLACES)),
    st.tuples(st.just("place"), st.sampled_from(BALLS), st.just("sk:heldBy"), st.just("gripper_1")),
    st.tuples(st.just("relate"), st.just("robot_1"), st.just("tiny:carries"), st.sampled_from(BALLS)),
    st.tuples(st.sampled_from(["relate", "unrelate"]), st.just("robot_1"), st.just("tiny:knows"), st.just("box_a")),
    st.tuples(st.just("place"), st.just("robot_1"), st.just("sk:at"), st.sampled_from(PLACES)),
    st.tuples(
        st.just("set"),
        st.sampled_from(BALLS),
        st.just("tiny:scanned"),
        st.sampled_from([True, False, None]),
    ),
    st.tuples(
        st.just("set"),
        st.sampled_from((*BALLS, *PLACES)),
        st.just("sk:pose"),
        st.sampled_from([Pose.of(x, 0.0, 0.0) for x in (0.0, 0.4, 5.0)] + [None]),
    ),
    st.tuples(st.just("set"), st.just("slot_1"), st.just("sk:drivingPose"), st.sampled_from([Pose.of(1, 0, 0), None])),
    st.tuples(st.just("remove"), st.sampled_from((*BALLS, "slot_1"))),
    st.tuples(st.just("add"), st.just("ball_9"), st.sampled_from(["tiny:RedBall", "tiny:Ball"])),
)


def apply(world: World, edit: tuple[object, ...]) -> None:
    """Does an edit; one that the world refuses changes nothing."""
    verb, *arguments = edit
    try:
        with world.transaction("test", "random") as tx:
            if verb == "add":
                tx.add(str(arguments[1]), id=str(arguments[0]))
                tx.place(str(arguments[0]), "sk:in", "box_a")
            else:
                getattr(tx, str(verb))(*arguments)
    except WorldError:
        pass


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(edits, st.lists(st.integers(0, 3), max_size=4)), max_size=15))
def test_after_any_edits_a_watch_answers_like_a_full_evaluation(
    history: list[tuple[tuple[object, ...], list[int]]],
) -> None:
    world = tiny_world("scene:ball_2 a tiny:Ball ; sk:in scene:box_a ; tiny:scanned true .")
    watches = Watches(world)
    each = [watches.add([condition]) for condition in CONDITIONS]
    groups = [watches.add(CONDITIONS[at::4]) for at in range(4)]

    for edit, asked in history:
        apply(world, edit)
        for at in asked:  # some are asked now and then only
            assert groups[at].broken() == afresh(world, CONDITIONS[at::4])
    for condition, watch in zip(CONDITIONS, each, strict=True):
        assert watch.broken() == afresh(world, [condition])
