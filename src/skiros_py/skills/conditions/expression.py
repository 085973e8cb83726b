"""Expressions over signals and parameters: ``Gripper.force > 2.0 and not Arm.still``, the one grammar for them.

A name is a parameter or value of the run (``limit``), a signal of a device that a parameter names (``Gripper.force``),
or a signal of the cell (``wrist_1.force``). A name in backquotes is always a signal of the cell.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache, lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, NoReturn

from lark import Lark, Token, Transformer, v_args
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken, VisitError

from skiros_py.errors import DescriptionError, UnknownName
from skiros_py.messages import Message, joined
from skiros_py.skills.conditions.condition import OPERATORS, Condition, ConditionType, kind_of
from skiros_py.skills.conditions.pattern import Binding, Pattern, Verdict, leaves
from skiros_py.world.literals import shown
from skiros_py.world.view import NO_SENSORS, WorldView

Lookup = Callable[[str], Any]
"""Gives the value of a name; raises :class:`_Unknown` where there is none."""
Term = Callable[[Lookup], Any]


class _Unknown(Exception):
    """An expression has no value; the text says why."""


@dataclass(frozen=True, slots=True)
class Sample:
    """Stands for the value of a name where an expression is checked without values.

    Attributes:
        name: The name.
        kinds: What its value can be: "number", "truth value", "text", "vector".
    """

    name: str
    kinds: frozenset[str]


@dataclass(frozen=True, slots=True)
class Expression:
    """A pattern that compares signals of this cycle and parameters: for hold conditions, guards and checks.

    Plans cannot use it, because they know no signals.

    Attributes:
        text: The expression.

    Raises:
        DescriptionError: The text is no expression; the message names the column and what would be right.
    """

    text: str

    def __post_init__(self) -> None:
        _parsed(self.text)

    @property
    def names(self) -> tuple[str, ...]:
        """The names in it that may be parameters, each once: of ``Gripper.force`` the part before the dot."""
        return tuple(dict.fromkeys(str(token).partition(".")[0] for token in _parsed(self.text).names))

    @property
    def quantities(self) -> tuple[tuple[str, str], ...]:
        """The names with a dot, split at the first one: ("Gripper", "force")."""
        parts = (str(token).partition(".") for token in _parsed(self.text).names)
        return tuple((head, rest) for head, _, rest in parts if rest)

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Computes it. What has no value now does not hold."""
        said: dict[str, str] = {}
        try:
            holds = _parsed(self.text).term(lambda name: _value_of(name, view, binding, said))
            if not isinstance(holds, bool):
                raise _Unknown(Message("'{text}' is {value}, not true or false", text=self.text, value=_said(holds)))
        except _Unknown as error:
            return Verdict(False, str(error))
        except ZeroDivisionError:
            return Verdict(False, Message("'{text}' divides by zero", text=self.text))
        values = joined(", ", [Message("{name} is {value}", name=name, value=value) for name, value in said.items()])
        if holds:
            return Verdict(True, values or self.text)
        return Verdict(False, Message("{values}, not {text}", values=values or self.text, text=self.text))

    def problem(self, kinds_of: Callable[[str], frozenset[str]]) -> str | None:
        """Returns why it can never hold, whatever its names stand for, or None.

        Args:
            kinds_of: Returns what the value of a name can be; see :class:`Sample`.
        """
        try:
            found = _parsed(self.text).term(lambda name: Sample(name.strip("`"), kinds_of(name)))
            _needs("truth value", f"'{self.text}' as a condition", found)
        except _Unknown as error:
            return str(error)
        except ZeroDivisionError:
            return f"'{self.text}' divides by zero"
        return None

    def rename(self, names: Mapping[str, str]) -> Expression:
        """Returns the same expression with other names of parameters."""
        text = self.text
        for token in reversed(_parsed(self.text).names):
            head, dot, rest = str(token).partition(".")
            begin = token.start_pos or 0
            text = f"{text[:begin]}{names.get(head, head)}{dot}{rest}{text[begin + len(token) :]}"
        return self if text == self.text else Expression(text)


@dataclass(frozen=True, slots=True)
class ExpressionCondition(Condition):
    """An expression as a condition; made by :func:`holds`."""

    def __invert__(self) -> Condition:
        return holds(f"not ({self.type.name})")

    @property
    def names(self) -> tuple[str, ...]:
        """The names in it that may be parameters."""
        pattern = self.type.pattern
        assert isinstance(pattern, Expression)
        return pattern.names

    def written(self, naming: Callable[[str], str]) -> str:  # noqa: ARG002 - it is written as its author did
        """Returns its text."""
        return self.type.name

    def evaluate(self, view: WorldView, binding: Binding | None = None) -> Verdict:
        """Computes it, with the values of parameters as they are bound."""
        inner = self.type.pattern.evaluate(view, binding or {})
        return Verdict(inner.holds, self.type.name, (inner,))


def holds(text: str) -> Condition:
    """Makes a condition of an expression over signals and parameters: ``holds("Gripper.force < limit")``.

    Raises:
        DescriptionError: The text is no expression; the message names the column and what would be right.
    """
    return ExpressionCondition(ConditionType(text, (), Expression(text), "An expression over signals."), ())


def is_sensed(pattern: Pattern) -> bool:
    """Tells whether a pattern reads signals anywhere: such a one means something in the live world only."""
    return any(isinstance(leaf, Expression) for leaf, _ in leaves(pattern))


# ---------------------------------------------------------------------- values


def _value_of(name: str, view: WorldView, binding: Mapping[str, Any], said: dict[str, str]) -> Any:
    """Returns the value of a name and notes it for the reason."""
    head, dot, rest = name.partition(".")
    if name.startswith("`"):
        name = name.strip("`")
    elif head in binding and binding[head] is None:
        raise _Unknown(Message("{head} is not specified", head=head))
    elif name in binding:
        said[name] = _said(binding[name])
        return binding[name]
    elif dot and head in binding:
        name = f"{binding[head]}.{rest}"
    value = view.sensors.value(name)
    if value is None:
        why = view.sensors.why_not(name)
        if view.sensors is NO_SENSORS:
            raise _Unknown(Message("no sensors here"))
        none = Message("there is no value of '{name}'", name=name)
        raise _Unknown(Message("{none}: {why}", none=none, why=why) if why else none)
    said[name] = _said(value)
    return value


def _said(value: Any) -> str:
    if isinstance(value, Sample):
        return value.name
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else shown(value)


def _kind(value: Any) -> str:
    if isinstance(value, Sample):
        return " or ".join(sorted(value.kinds))
    return kind_of(value) or ("vector" if isinstance(value, tuple) else type(value).__name__)


def _kinds(value: Any) -> frozenset[str]:
    return value.kinds if isinstance(value, Sample) else frozenset({_kind(value)})


def _sampled(values: Iterable[Any]) -> bool:
    return any(isinstance(value, Sample) for value in values)


def _needs(kind: str, what: str, *values: Any) -> None:
    for value in values:
        if kind not in _kinds(value):
            raise _Unknown(
                Message(
                    "{what} takes a {kind}, and {value} is a {other}",
                    what=what,
                    kind=kind,
                    value=_said(value),
                    other=_kind(value),
                )
            )


def _norm(vector: Any) -> Any:
    _needs("vector", "norm", vector)
    return _NUMBER if isinstance(vector, Sample) else math.hypot(*vector)


_NUMBER = Sample("a number", frozenset({"number"}))
_TRUTH = Sample("a truth value", frozenset({"truth value"}))


def _numeric(name: str, function: Callable[..., float]) -> Callable[..., Any]:
    def apply(*values: Any) -> Any:
        _needs("number", name, *values)
        return _NUMBER if _sampled(values) else function(*values)

    return apply


_FUNCTIONS: Mapping[str, Callable[..., Any]] = MappingProxyType(
    {
        "abs": _numeric("abs", abs),
        "max": _numeric("max", lambda *values: max(values)),
        "min": _numeric("min", lambda *values: min(values)),
        "norm": _norm,
    }
)


# ---------------------------------------------------------------------- grammar


def _operation(sign: str, function: Callable[..., float]) -> Callable[..., Term]:
    apply = _numeric(f"'{sign}'", function)

    def operation(_self: object, *parts: Term) -> Term:
        return lambda look_up: apply(*(part(look_up) for part in parts))

    return operation


@dataclass(frozen=True, slots=True)
class _Parsed:
    term: Term
    names: tuple[Token, ...] = field(default=())


@v_args(inline=True)
class _Terms(Transformer[Token, Term]):
    """Makes functions of a parse tree, from the inside out; collects the names of parameters and devices."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[Token] = []

    def disjunction(self, *parts: Term) -> Term:
        return lambda look_up: any(_truth("or", part(look_up)) for part in parts)

    def conjunction(self, *parts: Term) -> Term:
        return lambda look_up: all(_truth("and", part(look_up)) for part in parts)

    def negation(self, term: Term) -> Term:
        def negation(look_up: Lookup) -> Any:
            value = term(look_up)
            _needs("truth value", "'not'", value)
            return value if isinstance(value, Sample) else not value

        return negation

    def comparison(self, left: Term, sign: Token, right: Term) -> Term:
        return lambda look_up: _compare(left(look_up), str(sign), right(look_up))

    sum = _operation("+", operator.add)
    difference = _operation("-", operator.sub)
    product = _operation("*", operator.mul)
    quotient = _operation("/", operator.truediv)
    negative = _operation("-", operator.neg)

    def call(self, name: Token, *arguments: Term) -> Term:
        if name not in _FUNCTIONS:
            raise UnknownName("function", str(name), _FUNCTIONS)
        return lambda look_up: _FUNCTIONS[name](*(argument(look_up) for argument in arguments))

    def item(self, vector: Term, index: Token) -> Term:
        number = int(index)

        def item(look_up: Lookup) -> Any:
            value = vector(look_up)
            _needs("vector", f"[{number}]", value)
            if isinstance(value, Sample):
                return _NUMBER
            if number >= len(value):
                raise _Unknown(Message("there is no [{number}] in {count} values", number=number, count=len(value)))
            return value[number]

        return item

    def name(self, name: Token) -> Term:
        self.found.append(name)
        return self.signal(name)

    def signal(self, name: Token) -> Term:
        return lambda look_up: look_up(str(name))

    def number(self, number: Token) -> Term:
        return _constant(float(number))

    def text(self, text: Token) -> Term:
        return _constant(str(text)[1:-1].replace('\\"', '"'))

    def true(self) -> Term:
        return _constant(True)

    def false(self) -> Term:
        return _constant(False)


def _constant(value: float | str) -> Term:
    return lambda _look_up: value


def _truth(word: str, value: Any) -> bool:
    _needs("truth value", f"'{word}'", value)
    return word != "or" if isinstance(value, Sample) else bool(value)  # so that all parts are looked at


def _compare(left: Any, sign: str, right: Any) -> Any:
    if sign not in ("=", "==", "!="):
        _needs("number", f"'{sign}'", left, right)
    elif _kinds(left).isdisjoint(_kinds(right)):
        raise _Unknown(
            Message(
                "{left} ({kind}) cannot be compared with {right} ({other})",
                left=_said(left),
                kind=_kind(left),
                right=_said(right),
                other=_kind(right),
            )
        )
    return _TRUTH if _sampled((left, right)) else bool(OPERATORS[sign.replace("==", "=")](left, right))


@cache
def _grammar() -> Lark:
    return Lark((Path(__file__).parent / "expression.lark").read_text(encoding="utf-8"), parser="lalr")


@lru_cache(maxsize=1024)
def _parsed(text: str) -> _Parsed:
    terms = _Terms()
    try:
        return _Parsed(terms.transform(_grammar().parse(text)), tuple(terms.found))
    except UnexpectedInput as error:
        _refuse(text, error)
    except VisitError as error:
        raise DescriptionError(f"expression '{text}': {error.orig_exc}") from error


def syntax_fault(text: str, error: UnexpectedInput) -> tuple[int, set[str]]:
    """Returns the column, in the whole text, from which it cannot be parsed, and the names of what may stand there."""
    at_end = isinstance(error, UnexpectedToken) and error.token.type == "$END"
    column = len(text.rstrip()) + 1 if at_end else (error.pos_in_stream or 0) + 1
    wanted: set[str] = set()
    if isinstance(error, UnexpectedToken):
        wanted = set(error.accepts or error.expected)
    elif isinstance(error, UnexpectedCharacters):
        wanted = set(error.allowed or ())
    return column, wanted


def _refuse(text: str, error: UnexpectedInput) -> NoReturn:
    column, wanted = syntax_fault(text, error)
    right = "an operator such as 'and', '<' or '+', or the end"
    if "NAME" in wanted:
        right = "a value: a name such as Gripper.force, a number, true, false, a text or '('"
    raise DescriptionError(f"expression '{text}', column {column}: expected {right}")
