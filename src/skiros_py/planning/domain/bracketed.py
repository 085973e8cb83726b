"""PDDL as bracketed terms, to rewrite generated texts."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

Term = str | list["Term"]
"""A word, or terms in brackets."""


def read_term(text: str) -> list[Term]:
    """Parses a text without comments as a bracketed term."""
    stack: list[list[Term]] = [[]]
    for word in re.findall(r"[()]|[^\s()]+", text):
        if word == "(":
            stack.append([])
        elif word == ")":
            done = stack.pop()
            stack[-1].append(done)
        else:
            stack[-1].append(word)
    return next(term for term in stack[0] if isinstance(term, list))


def shown(term: Term) -> str:
    """Returns a term as text, on one line."""
    return term if isinstance(term, str) else f"({' '.join(map(shown, term))})"


def words(term: Term) -> Iterator[str]:
    """Yields every word of a term."""
    if isinstance(term, str):
        yield term
    else:
        for part in term:
            yield from words(part)


def field(action: Sequence[Term], keyword: str) -> list[Term]:
    """Returns what follows a keyword of an action."""
    value = action[action.index(keyword) + 1]
    assert isinstance(value, list)
    return value


def conjuncts(term: list[Term]) -> list[list[Term]]:
    """Returns the parts of a conjunction; the term itself if it is not a conjunction."""
    return [part for part in (term[1:] if term[:1] == ["and"] else [term]) if isinstance(part, list)]


def typed_lines(terms: Sequence[Term]) -> Iterator[str]:
    """Yields each "a b - type" as a line of its own."""
    line: list[str] = []
    before = ""
    for word in map(str, terms):
        line.append(word)
        if before == "-":
            yield " ".join(line)
            line = []
        before = word
    if line:
        yield " ".join(line)


def block(keyword: str, lines: Sequence[str]) -> str:
    """Returns a keyword with a conjunction, one part per line."""
    return f"    {keyword} (and" + "".join(f"\n      {line}" for line in lines) + ")"


def unused(word: str, text: str) -> str:
    """Returns a word, with a number appended if a text contains it already."""
    taken, name, number = set(re.findall(r"[\w-]+", text)), word, 1
    while name in taken:
        number += 1
        name = f"{word}-{number}"
    return name
