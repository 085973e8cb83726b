"""Each rule has a page, and the examples on it are true: the first breaks this rule and no other, the second none."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from skiros_py.checking.plugin_check import as_installed, check_plugins
from skiros_py.skills.lint.checking import RULES
from skiros_py.skills.lint.rule import Rule

DOCS = Path(__file__).parents[3] / "docs"
EXAMPLE = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
Package = Callable[[str], Path]

RUN = {rule.name for rule in RULES.values() if rule.check is None}
"""Rules that are about loading and running."""


def examples(rule: Rule) -> tuple[str, str]:
    bad, good = EXAMPLE.findall(rule.page)
    return bad, good


def broken_by(folder: Path, *, run: bool) -> set[str]:
    with as_installed(folder) as name:
        return {finding.rule for finding in check_plugins(name, run=run).findings}


@pytest.mark.parametrize("rule", RULES.values(), ids=lambda r: r.name)
def test_the_bad_example_of_a_rule_breaks_exactly_this_rule(rule: Rule, package: Package) -> None:
    bad, _ = examples(rule)

    assert broken_by(package(bad), run=rule.name in RUN) == {rule.name}


@pytest.mark.parametrize("rule", RULES.values(), ids=lambda r: r.name)
def test_the_good_example_of_a_rule_breaks_no_rule(rule: Rule, package: Package) -> None:
    _, good = examples(rule)

    assert broken_by(package(good), run=rule.name in RUN) == set()


@pytest.mark.parametrize("rule", RULES.values(), ids=lambda r: r.name)
def test_the_page_of_a_rule_begins_with_its_name_and_the_summary_is_a_sentence(rule: Rule) -> None:
    assert rule.page.startswith(f"# {rule.name}\n")
    assert rule.summary.endswith(".")


def test_the_docs_list_all_rules_with_their_current_texts() -> None:
    text = (DOCS / "rules.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| \[([a-z-]+)\]\(([^)]+)\) \| (\w+) \| (.+?) \|$", text, re.MULTILINE)

    assert [(name, severity, summary) for name, _, severity, summary in listed] == [
        (rule.name, rule.severity.value, rule.summary) for rule in RULES.values()
    ]
    assert all((DOCS / link).read_text(encoding="utf-8") == RULES[name].page for name, link, _, _ in listed)
