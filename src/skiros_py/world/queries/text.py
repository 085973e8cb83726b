"""A query as text: what it asks for, what it mentions, and the places where parameters go."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache

import pyoxigraph as ox

from skiros_py.errors import UnknownName, UsageError
from skiros_py.world.names import Names
from skiros_py.world.queries.tokens import Token, decoded_iri, decoded_local, decoded_text, tokens

__all__ = ["DEEPEST", "QueryText", "parsed"]

DEEPEST = 100
"""Brackets within brackets that a query may have: engines that read by recursion die of thousands."""

_FORMS = ("SELECT", "ASK", "CONSTRUCT")
_UPDATES = ("INSERT", "DELETE", "LOAD", "CLEAR", "DROP", "CREATE", "ADD", "MOVE", "COPY", "WITH")
_REFUSED = {
    "SERVICE": "the query asks another server (SERVICE); only this world can be asked",
    "FROM": "the query names its graphs (FROM); leave that out: all graphs are asked as one, GRAPH <…> {…} asks one",
    "LOAD": "the query fetches a file (LOAD); only what is in this world can be asked",
}


@dataclass(frozen=True, slots=True)
class QueryText:
    """A query that was looked through; see :func:`parsed`.

    Attributes:
        form: "SELECT", "ASK" or "CONSTRUCT".
        pieces: The text, with IRIs in full; each second piece is the name of a parameter.
        iris: The IRIs that it mentions.
        parameters: The names of its parameters.
    """

    form: str
    pieces: tuple[str, ...]
    iris: frozenset[str]
    parameters: frozenset[str]

    def filled(self, terms: Mapping[str, ox.NamedNode | ox.Literal]) -> str:
        """Returns the query with terms for its parameters.

        Raises:
            UsageError: A parameter has no term, or a term has no parameter.
        """
        unbound = sorted(self.parameters.difference(terms))
        if unbound:
            bound = ", ".join(sorted(terms)) or "nothing"
            raise UsageError(
                f"nothing is bound to ${', $'.join(unbound)}; bound: {bound} (variables are written ?name)"
            )
        unused = sorted(set(terms) - self.parameters)
        if unused:
            raise UsageError(f"the query has no parameter ${', $'.join(unused)}")
        # A term writes itself escaped, so that no value can become query text.
        return "".join(str(terms[piece]) if at % 2 else piece for at, piece in enumerate(self.pieces))


@lru_cache(maxsize=512)
def parsed(sparql: str, names: Names) -> QueryText:
    """Looks a query through without running it.

    Names with prefixes become IRIs in full. So what the engine reads is what was looked at here: it needs no blank
    between a keyword and a name, and would take ``SERVICE:x`` for both.

    Raises:
        UsageError: It is no query, changes something, asks beyond this world, or is nested too deep.
    """
    return _Reader(names).read(sparql)


class _Reader:
    def __init__(self, names: Names) -> None:
        self._prefixes = dict(names.prefixes)
        self._form: str | None = None
        self._pieces = [""]
        self._iris: set[str] = set()
        self._depth = 0

    def read(self, sparql: str) -> QueryText:
        found = list(tokens(sparql))
        _check_runs(found)
        waiting = iter(found)
        for token in waiting:
            self._take(token, waiting)
        if self._form is None:
            raise UsageError("the query is empty: it needs SELECT, ASK or CONSTRUCT")
        parameters = frozenset(self._pieces[1::2])
        return QueryText(self._form, tuple(self._pieces), frozenset(self._iris), parameters)

    def _take(self, token: Token, following: Iterator[Token]) -> None:
        if token.kind == "word":
            self._word(token, following)
        elif token.kind == "name":
            self._name(token)
        elif token.kind == "iri":
            self._iri(decoded_iri(token.text))
        elif token.kind == "parameter":
            self._pieces += [token.text[1:], ""]
        elif token.kind == "comment":
            self._write(" ")
        else:
            self._count(token)
            self._write(decoded_text(token.text) if token.kind == "text" else token.text)

    def _word(self, token: Token, following: Iterator[Token]) -> None:
        word = token.text.upper()
        for refused, why in _REFUSED.items():
            if refused in word:  # the engine needs no blank between two keywords
                raise UsageError(why)
        if word == "PREFIX" and self._form is None:
            self._declare(following)
            return
        if self._form is None:
            self._form = _checked_form(word)
        self._write(token.text)

    def _declare(self, following: Iterator[Token]) -> None:
        meant = (token for token in following if not self._is_blank(token))
        name, iri = next(meant, None), next(meant, None)
        if name is None or iri is None or name.kind != "name" or not name.text.endswith(":") or iri.kind != "iri":
            raise UsageError("the query does not parse: PREFIX needs a name and an IRI, as in PREFIX ex: <http://…#>")
        self._prefixes[name.text[:-1]] = decoded_iri(iri.text)

    def _is_blank(self, token: Token) -> bool:
        self._write("\n" * token.text.count("\n"))  # so that the engine counts lines as its author does
        return token.kind in ("blank", "comment")

    def _name(self, token: Token) -> None:
        prefix, _, local = token.text.partition(":")
        if prefix == "_":
            self._write(f" {token.text} ")
        elif prefix not in self._prefixes:
            raise UnknownName("prefix", prefix, self._prefixes, where=f"in '{token.text}'")
        else:
            self._iri(self._prefixes[prefix] + decoded_local(local))

    def _iri(self, iri: str) -> None:
        self._iris.add(iri)
        self._write(f"<{iri}>")

    def _count(self, token: Token) -> None:
        self._depth += (token.kind == "open") - (token.kind == "close")
        if self._depth > DEEPEST:
            raise UsageError(f"the query is nested too deep: {DEEPEST} brackets within each other are the most")

    def _write(self, text: str) -> None:
        self._pieces[-1] += text


def _checked_form(word: str) -> str:
    if word in _FORMS:
        return word
    if word in _UPDATES:
        raise UsageError(f"{word} changes triples, and a query cannot: the world changes by transactions only")
    if word == "DESCRIBE":
        raise UsageError("DESCRIBE does not say what it answers: write CONSTRUCT")
    if word == "BASE":
        raise UsageError("the query shortens IRIs by BASE: use prefixes, or write them in full")
    raise UsageError(f"the query begins with '{word[:40]}', and must with SELECT, ASK or CONSTRUCT")


def _check_runs(found: list[Token]) -> None:
    """Signs before something nest like brackets: ``!!!!x``, ``- - -x``, ``^^^^x``."""
    run = 0
    for token in found:
        if token.kind == "sign" and token.text in ("!", "+", "-", "^", "^^"):
            run += len(token.text)
        elif token.kind not in ("blank", "comment"):
            run = 0
        if run > DEEPEST:
            raise UsageError(f"the query is nested too deep: {DEEPEST} signs before something are the most")
