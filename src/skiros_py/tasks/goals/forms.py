"""A parsed goal with words not yet looked up, which is also its form as plain data; and its two written forms.

As plain data, for programs: dictionaries and lists, as JSON has them, checked by pydantic::

    {"condition": "InKit", "arguments": ["Starter", "kit_1"]}
    {"not": GOAL}   {"all_of": [GOAL, …]}   {"any_of": [GOAL, …]}   {"if": GOAL, "then": GOAL}
    {"for_all": "c", "class": "Compartment", "holds": GOAL}   {"exists": "p", "class": "Starter", "holds": GOAL}
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Annotated, Any, ClassVar

from lark import Lark, Token, Transformer
from lark.exceptions import UnexpectedInput
from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, GetPydanticSchema, Tag, TypeAdapter

from skiros_py.errors import GoalSyntaxError
from skiros_py.messages import Message, joined, listed
from skiros_py.skills.conditions.expression import syntax_fault
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


_Argument = Annotated[
    Name, GetPydanticSchema(lambda _, schema_of: schema_of(Annotated[str, AfterValidator(lambda text: Name(text))]))
]


class _Form(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Word(_Form):
    """A condition's word with its arguments."""

    condition: str
    arguments: list[_Argument]


class Negation(_Form):
    """It must not hold."""

    part: Form = Field(alias="not")


class AllOf(_Form):
    """All of them hold."""

    word: ClassVar[str] = "and"
    parts: list[Form] = Field(alias="all_of", min_length=1)


class AnyOf(_Form):
    """At least one of them holds."""

    word: ClassVar[str] = "or"
    parts: list[Form] = Field(alias="any_of", min_length=1)


class Implication(_Form):
    """If one condition holds, so does the other."""

    premise: Form = Field(alias="if")
    then: Form


class ForAll(_Form):
    """It holds for all elements of a class."""

    quantifier: ClassVar[str] = "for all"
    variable: str = Field(alias="for_all")
    class_: str = Field(alias="class")
    holds: Form


class Exists(_Form):
    """It holds for some element of a class."""

    quantifier: ClassVar[str] = "exists"
    variable: str = Field(alias="exists")
    class_: str = Field(alias="class")
    holds: Form


_KINDS = ("condition", "not", "all_of", "any_of", "if", "for_all", "exists")


def _kind(value: object) -> str | None:
    """Returns the kind of a goal as plain data, from the first field that determines it."""
    if not isinstance(value, Mapping):
        return None
    return next((f"<{kind}>" for kind in _KINDS if kind in value), None)


Form = Annotated[
    Annotated[Word, Tag("<condition>")]
    | Annotated[Negation, Tag("<not>")]
    | Annotated[AllOf, Tag("<all_of>")]
    | Annotated[AnyOf, Tag("<any_of>")]
    | Annotated[Implication, Tag("<if>")]
    | Annotated[ForAll, Tag("<for_all>")]
    | Annotated[Exists, Tag("<exists>")],
    Discriminator(
        _kind,
        custom_error_type="goal",
        custom_error_message=f"expected an object with one of the fields {', '.join(_KINDS)}",
    ),
]

FORMS: TypeAdapter[list[Form]] = TypeAdapter(list[Form])
"""A list of goals as plain data."""

_LONGEST_PATH = 20


def field_path(location: Sequence[int | str]) -> str:
    """Returns the path to a field of a goal ("[0].not.arguments[1]"); names in angle brackets are kinds, not fields."""
    fields = [
        f"[{part}]" if isinstance(part, int) else f".{part}" for part in location if not str(part).startswith("<")
    ]
    if len(fields) > _LONGEST_PATH:
        fields[_LONGEST_PATH // 2 : -_LONGEST_PATH // 2] = ["…"]
    return "".join(fields)


PLAIN = re.compile(r"[^\W\d](?:[\w.-]|:(?=\w))*")
"""A name that needs no quotes."""


def quoted(name: str) -> str:
    """Returns a name as goals are written, in double quotes if the grammar requires them."""
    return name if PLAIN.fullmatch(name) else '"' + re.sub(r'(["\\])', r"\\\1", name) + '"'


_WORDS: Mapping[str, str] = {
    "LPAR": "'('",
    "RPAR": "')'",
    "COMMA": "','",
    "COLON": "':'",
    "MINUS": "'-'",
    "NAME": Message("a name"),
    "QUOTED": Message("a name"),
    "SYMBOL": Message("a name"),
    "VARIABLE": Message("a variable"),
    "WORD": Message("the word of a condition"),
    "_NOT": "'not'",
    "_AND": "'and'",
    "_OR": "'or'",
    "_IMPLIES": "'implies'",
    "_IMPLY": "'imply'",
    "_FOR_ALL": "'for all'",
    "_FORALL": "'forall'",
    "_EXISTS": "'exists'",
    "$END": Message("the end"),
}


@lru_cache(maxsize=128)
def read(text: str) -> Form:
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


def _read(text: str, form: str) -> Form:
    try:
        parsed: Form = _grammar(form).parse(text)  # type: ignore[assignment]  # the transformer's result
    except UnexpectedInput as error:
        column, wanted = syntax_fault(text, error)
        raise GoalSyntaxError(re.sub(r"\s", " ", text), column, _reason(wanted)) from error
    return parsed


@cache
def _grammar(form: str) -> Lark:
    text = (Path(__file__).parent / f"{form}.lark").read_text(encoding="utf-8")
    return Lark(text, parser="lalr", transformer=_Text() if form == "text" else _Pddl())


def _reason(names: set[str]) -> str:
    if {"WORD", "LPAR"} <= names:  # at the beginning of a condition
        return Message("expected a condition such as InKit(Starter, kit_1)")
    *most, last = sorted({_WORDS[name] for name in names if name in _WORDS}) or [Message("a condition")]
    return Message("expected {words}", words=listed((joined(", ", most), last) if most else (last,), either=True))


class _Common(Transformer[Token, Form]):
    """What both grammars share; called by the parser from the inside out, so depth does not matter."""

    def start(self, parts: Sequence[Form]) -> Form:
        return parts[0]

    def condition(self, parts: Sequence[Token]) -> Word:
        return Word.model_construct(condition=str(parts[0]), arguments=[*map(_name, parts[1:])])

    def conjunction(self, parts: Sequence[Form]) -> AllOf:
        return AllOf.model_construct(parts=[*parts])

    def disjunction(self, parts: Sequence[Form]) -> AnyOf:
        return AnyOf.model_construct(parts=[*parts])

    def negation(self, parts: Sequence[Form]) -> Negation:
        return Negation.model_construct(part=parts[0])

    def implication(self, parts: Sequence[Form]) -> Form:
        *premises, result = parts
        for premise in reversed(premises):
            result = Implication.model_construct(premise=premise, then=result)
        return result

    def for_all(self, parts: Sequence[Any]) -> Form:
        return _quantified(ForAll, parts)

    def exists(self, parts: Sequence[Any]) -> Form:
        return _quantified(Exists, parts)


class _Text(_Common):
    """Goals in text form."""

    def declaration(self, parts: Sequence[Token]) -> list[tuple[str, str]]:
        return [(str(parts[0]), _name(parts[1]).text)]


class _Pddl(_Common):
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


def _quantified(kind: type[ForAll | Exists], parts: Sequence[Any]) -> Form:
    *declarations, result = parts
    for variable, class_ in reversed([one for declaration in declarations for one in declaration]):
        result = kind.model_construct(variable=variable, class_=class_, holds=result)
    return result  # type: ignore[no-any-return]  # the last part is the inner goal
