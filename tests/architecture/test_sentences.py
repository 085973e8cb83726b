"""Sentences for people can be said in the languages of the pages."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from skiros_py import errors
from skiros_py.catalogue import load_catalogue
from skiros_py.errors import SkirosError
from skiros_py.skills.parameters import Param, params_of

ROOT = Path(__file__).parents[2]
SOURCES = ("src", "primitives/src", "skills/src", "robots/src", "systems/uav/src")
GERMAN = json.loads((ROOT / "web/src/i18n/de/server.json").read_text())
ERRORS = {name for name, class_ in vars(errors).items() if getattr(class_, "__init__", None) is SkirosError.__init__}
"""Classes of errors that make a message of a template and values."""
_FIELD = re.compile(r"\{(\w+):?[^{}]*\}")


def _made(tree: ast.AST) -> Iterator[ast.expr]:
    """Yields the templates of messages: of Message("…"), partial(Message, "…") and UsageError("…", x=x)."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            names = [word.id if isinstance(word, ast.Name) else "" for word in (node.func, *node.args)]
            if names[:1] == ["Message"] or (names[0] in ERRORS and node.keywords):
                yield node.args[0]
            elif names[:2] == ["partial", "Message"]:
                yield node.args[1]


def _templates() -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for source in SOURCES:
        for path in sorted((ROOT / source).rglob("*.py")):
            if path == ROOT / "src/skiros_py/messages.py":  # its own templates join other texts
                continue
            for made in _made(ast.parse(path.read_text())):
                assert isinstance(made, ast.Constant), f"{path}:{made.lineno}: the template must be a literal"
                template = _FIELD.sub(r"{\1}", str(made.value))
                found.setdefault(template, []).append(f"{path.relative_to(ROOT)}:{made.lineno}")
    return found


def _helps() -> set[str]:
    """Returns the help of the built-in skills, primitives, conditions and their parameters."""
    catalogue = load_catalogue()
    described: list[tuple[str, tuple[Param, ...]]] = []
    described += [(skill.description.help, skill.description.params) for skill in catalogue.skills.values()]
    described += [
        ((primitive.__doc__ or "").strip().partition("\n")[0], params_of(primitive.Params))
        for primitive in catalogue.primitives.values()
    ]
    outputs = (output.help for primitive in catalogue.primitives.values() for output in primitive.outputs)
    words = (type_.help for type_ in catalogue.conditions.values())
    return {*outputs, *words, *(text for help_, params in described for text in (help_, *(p.help for p in params)))} - {
        ""
    }


def _fields(text: str) -> set[str]:
    return set(_FIELD.findall(text))


def _is_sentence(template: str) -> bool:
    return re.search(r"[^\W\d_]", _FIELD.sub("", template)) is not None


def test_every_sentence_has_a_german_text_with_the_same_values() -> None:
    wanted = {template: places for template, places in _templates().items() if _is_sentence(template)}
    assert len(wanted) > 300
    missing = {template: places[0] for template, places in wanted.items() if template not in GERMAN}
    assert not missing
    assert not _helps() - GERMAN.keys()
    differing = {template for template in wanted if GERMAN[template] and _fields(template) != _fields(GERMAN[template])}
    assert not differing


def test_every_german_text_belongs_to_a_sentence() -> None:
    assert not GERMAN.keys() - _templates().keys() - _own() - _helps()


def _own() -> set[str]:
    tree = ast.parse((ROOT / "src/skiros_py/messages.py").read_text())
    return {str(made.value) for made in _made(tree) if isinstance(made, ast.Constant)}


@pytest.mark.parametrize("template", sorted(_own()))
def test_the_words_that_join_texts_have_a_german_text(template: str) -> None:
    assert _fields(GERMAN[template]) == _fields(template)
