from __future__ import annotations

import contextlib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.errors import PlanningError
from skiros_py.planning.planners.planner import Solved
from skiros_py.planning.planners.program_planner import last_plan_file, read_plan_file, read_plan_text, steps_among

WORD = st.from_regex(r"[a-z][a-z0-9_-]{0,8}", fullmatch=True)
STEPS = st.lists(st.lists(WORD, min_size=1, max_size=4).map(tuple), max_size=6).map(tuple)


@given(STEPS)
def test_a_written_plan_is_read_back_unchanged(steps: tuple[tuple[str, ...], ...]) -> None:
    text = "".join(f"({' '.join(step)}) \n" for step in steps) + "; cost = 3 (unit cost)\n"

    assert read_plan_text("it", text) == Solved(steps)


@given(STEPS, st.randoms())
def test_a_plan_with_times_is_read_in_order_of_start_times(steps: tuple[tuple[str, ...], ...], random: object) -> None:
    lines = [f"{0.5 * i:.3f}: ({' '.join(step)})  [{i}.250]" for i, step in enumerate(steps)]
    random.shuffle(lines)  # type: ignore[attr-defined]

    found = read_plan_text("it", "\n".join(lines))

    assert found.steps == steps
    assert found.starts == tuple(0.5 * i for i in range(len(steps)))
    assert found.durations == tuple(i + 0.25 for i in range(len(steps)))


@given(st.text(max_size=200))
def test_any_text_is_a_plan_or_a_planning_error(text: str) -> None:
    with contextlib.suppress(PlanningError):
        assert isinstance(read_plan_text("it", text), Solved)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("(a x)\n(b y", r"it wrote a plan whose line 2 is no step: '\(b y'"),
        ("Segmentation fault", "line 1 is no step: 'Segmentation fault'"),
        ("()", "line 1 is no step"),
        ("(a x) (b y)", "line 1 is no step"),
        ("0.0: (a x) [1]\n(b y)", "in which 1 of 2 steps have a time"),
        ("x" * 500, "x{80}…"),
    ],
)
def test_a_plan_that_is_cut_off_or_garbage_names_the_line(text: str, words: str) -> None:
    with pytest.raises(PlanningError, match=words):
        read_plan_text("it", text)


def test_names_are_read_in_lower_case() -> None:
    assert read_plan_text("it", "(DRIVE Base_1)") == Solved((("drive", "base_1"),))


def test_steps_are_found_among_other_output() -> None:
    text = "Planning...\n;;;; Solution Found\n0.000: (a x)  [1.000]\nTime: 0.1 (b)\n"

    assert steps_among("it", text) == Solved((("a", "x"),), (0.0,), (1.0,))
    assert steps_among("it", "Planning...\nno luck") is None


def test_the_last_of_several_numbered_plans_is_used(tmp_path: Path) -> None:
    for number in (1, 2, 10):
        (tmp_path / f"sas_plan.{number}").write_text("")

    assert last_plan_file(tmp_path, "sas_plan*") == tmp_path / "sas_plan.10"
    assert last_plan_file(tmp_path, "plan") is None


def test_a_symbolic_link_out_of_the_folder_is_not_read_as_a_plan(tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("(a)")
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "plan").symlink_to(tmp_path / "secret")

    assert last_plan_file(folder, "plan") is None


def test_a_file_that_cannot_be_read_or_is_huge_is_a_fault(tmp_path: Path) -> None:
    huge = tmp_path / "plan"
    with huge.open("wb") as file:
        file.truncate(17 << 20)

    with pytest.raises(PlanningError, match="more than 16 MiB"):
        read_plan_file("it", huge)
    with pytest.raises(PlanningError, match="cannot be read: No such file"):
        read_plan_file("it", tmp_path / "missing")
