"""The table of hard cases names tests: each of them is there, and each case has some.

There is no BT XML (case 12), and skill managers live in one process: of case 15 none is killed or frozen by itself.
"""

from __future__ import annotations

import re
from pathlib import Path

TESTS = Path(__file__).parents[1]
TABLE = TESTS.parent / "docs" / "rest" / "hard-cases.md"
ROW = re.compile(r"^\| (\d+) [^|]*\|[^|]*\|([^|]*)\|$", re.MULTILINE)
WITHOUT_TESTS = {12}


def rows() -> dict[int, list[str]]:
    text = TABLE.read_text(encoding="utf-8")
    return {int(number): re.findall(r"`(test_\w+)`", tests) for number, tests in ROW.findall(text)}


def test_each_of_the_twenty_cases_is_in_the_table_with_its_tests() -> None:
    assert [*rows()] == [*range(1, 21)]
    assert {number for number, tests in rows().items() if not tests} == WITHOUT_TESTS


def test_each_test_that_the_table_names_exists() -> None:
    texts = (file.read_text(encoding="utf-8") for file in TESTS.rglob("test_*.py"))
    there = {name for text in texts for name in re.findall(r"^\s*def (test_\w+)\(", text, re.MULTILINE)}

    assert {name for names in rows().values() for name in names} - there == set()
