"""The two written forms of goals, each with its own grammar, and a parsed goal with words not yet looked up."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, Literal

from lark import Lark, Token, Transformer
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from skiros_py.errors import GoalSyntaxError
from skiros_py.world.vocabulary import ELEMENT


@dataclass(frozen=True, slots=True)
class Name:
    """The name of an argument.

    Attributes:
        text: Id, label or class of an element, or a variable.
        variable: True if it can only be a variable (PDDL's ``?x``), False if it cannot be one (in quotes, or
            without a question mark in PDDL).
    """

    text: str
    variable: bool | None = None


@dataclass(frozen=True, slots=True)
class Word:
    """A condition's word with its arguments."""

    word: str
    arguments: tuple[Name, ...]


@dataclass(frozen=True, slots=True)
class Negation:
    """It must not hold."""

    part: Said


@dataclass(frozen=True, slots=True)
class Joined:
    """All of them, or any of them."""

    word: Literal["and", "or"]
    parts: tuple[Said, ...]


@dataclass(frozen=True, slots=True)
class Quantification:
    """For all elements of a class, or for some."""

    quantifier: Literal["for all", "exists"]
    variable: str
    class_: str
    part: Said


Said = Word | Negation | Joined | Quantification


def implication(premises: Sequence[Said]) -> Said:
    """Returns "a implies b implies c", that is "not a or (not b or c)"; a single one is returned as it is."""
    result = premises[-1]
    for premise in reversed(premises[:-1]):
        result = Joined("or", (Negation(premise), result))
    return result


_WORDS: Mapping[str, str] = {
    "LPAR": "'('",
    "RPAR": "')'",
    "COMMA": "','",
    "COLON": "':'",
    "MINUS": "'-'",
    "NAME": "a name",
    "QUOTED": "a name",
    "SYMBOL": "a name",
    "VARIABLE": "a variable",
    "WORD": "the word of a condition",
    "_NOT": "'not'",
    "_AND": "'and'",
    "_OR": "'or'",
    "_IMPLIES": "'implies'",
    "_IMPLY": "'imply'",
    "_FOR_ALL": "'for all'",
    "_FORALL": "'forall'",
    "_EXISTS": "'exists'",
    "$END": "the end",
}


@lru_cache(maxsize=128)
def read(text: str) -> Said:
    """Reads a goal written as text or, in parentheses, as PDDL; cached, since a factory repeats the same few goals.

    Raises:
        GoalSyntaxError: It is neither; the message gives the error position in the form that matches further.
    """
    try:
        return _read(text, "text")
    except GoalSyntaxError as error:
        if not text.lstrip().startswith(("(", ";")):
            raise
        try:
            return _read(text, "pddl")
        except GoalSyntaxError as other:
            raise max(other, error, key=lambda fault: fault.column) from None


def _read(text: str, form: str) -> Said:
    try:
        said: Said = _grammar(form).parse(text)  # type: ignore[assignment]  # the transformer's result
    except UnexpectedInput as error:
        raise GoalSyntaxError(re.sub(r"\s", " ", text), _column(error, text), _reason(error)) from error
    return said


@cache
def _grammar(form: str) -> Lark:
    text = (Path(__file__).parent / f"{form}.lark").read_text(encoding="utf-8")
    return Lark(text, parser="lalr", transformer=_Text() if form == "text" else _Pddl())


def _column(error: UnexpectedInput, text: str) -> int:
    """Returns the position in the whole text, which may have several lines."""
    at_end = isinstance(error, UnexpectedToken) and error.token.type == "$END"
    return len(text.rstrip()) + 1 if at_end else (error.pos_in_stream or 0) + 1


def _reason(error: UnexpectedInput) -> str:
    names: set[str] = set()
    if isinstance(error, UnexpectedToken):
        names = set(error.accepts or error.expected)
    elif isinstance(error, UnexpectedCharacters):
        names = set(error.allowed or ())
    if {"WORD", "LPAR"} <= names:  # at the beginning of a condition
        return "expected a condition such as InKit(Starter, kit_1)"
    *most, last = sorted({_WORDS[name] for name in names if name in _WORDS}) or ["a condition"]
    return f"expected {', '.join(most)}{' or ' if most else ''}{last}"


class _Form(Transformer[Token, Said]):
    """The common part of both forms; called by the parser from the inside out, so depth does not matter."""

    def start(self, parts: Sequence[Said]) -> Said:
        return parts[0]

    def condition(self, parts: Sequence[Token]) -> Word:
        return Word(str(parts[0]), tuple(map(_name, parts[1:])))

    def conjunction(self, parts: Sequence[Said]) -> Joined:
        return Joined("and", tuple(parts))

    def disjunction(self, parts: Sequence[Said]) -> Joined:
        return Joined("or", tuple(parts))

    def negation(self, parts: Sequence[Said]) -> Negation:
        return Negation(parts[0])

    def implication(self, parts: Sequence[Said]) -> Said:
        return implication(parts)

    def for_all(self, parts: Sequence[Any]) -> Said:
        return _quantified("for all", parts)

    def exists(self, parts: Sequence[Any]) -> Said:
        return _quantified("exists", parts)


class _Text(_Form):
    """Goals in text form."""

    def declaration(self, parts: Sequence[Token]) -> list[tuple[str, str]]:
        return [(str(parts[0]), _name(parts[1]).text)]


class _Pddl(_Form):
    """Goals in PDDL form."""

    def declaration(self, parts: Sequence[Token]) -> list[tuple[str, str]]:
        *variables, class_ = map(_name, parts)
        named = ELEMENT if class_.text.lower() == "object" else class_.text
        return [(variable.text, named) for variable in variables]

    def last_declaration(self, parts: Sequence[Token]) -> list[tuple[str, str]]:
        return [(_name(part).text, ELEMENT) for part in parts]


def _name(token: Token) -> Name:
    if token.type == "QUOTED":
        return Name(re.sub(r"\\(.)", r"\1", token[1:-1], flags=re.DOTALL), variable=False)
    if token.type == "VARIABLE":
        return Name(token.removeprefix("?").replace("-", "_"), variable=True)
    return Name(str(token), variable=False if token.type == "SYMBOL" else None)


def _quantified(quantifier: Literal["for all", "exists"], parts: Sequence[Any]) -> Said:
    said: Said = parts[-1]
    for variable, class_ in reversed([one for declaration in parts[:-1] for one in declaration]):
        said = Quantification(quantifier, variable, class_, said)
    return said
