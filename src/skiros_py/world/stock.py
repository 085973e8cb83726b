"""Stock: a number of things of a class in a container, without individuals until one is taken (paper §6.3).

In plans, a token such as "bolts_a#2" stands for one that has not been taken yet. Tokens of one stock are
interchangeable: the number only distinguishes them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from skiros_py.errors import WorldError
from skiros_py.world.element import Element, Placement
from skiros_py.world.names import local_name
from skiros_py.world.overlay import Overlay
from skiros_py.world.transaction import Transaction
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import CONTAINER, HAS_A, IN, ON, STOCK, STOCK_COUNT, STOCK_OF

_MARK = "#"
"""Separates a token's stock from its number; does not occur in ids."""


@dataclass(frozen=True, slots=True)
class Stock:
    """The things of one class in stock at one place.

    Attributes:
        id: Its element id.
        class_: CURIE of the class of the things.
        count: How many there are without an individual, at least one.
        placement: Where they are.
    """

    id: str
    class_: str
    count: int
    placement: Placement

    def token(self, number: int) -> str:
        """Returns the name of one of the things, numbered from 1."""
        return f"{self.id}{_MARK}{number}"


class Stocked(Overlay):
    """A world in which some things of its stocks are elements, under the names of their tokens.

    Attributes:
        short: True if a stock has more than are shown.
    """

    def __init__(self, base: WorldView, shown: Mapping[Stock, Iterable[str]]) -> None:
        super().__init__(base)
        self.short = False
        for stock, tokens in shown.items():
            names = tuple(tokens)
            self.short = self.short or len(names) < stock.count
            for name in names:
                label = f"{local_name(stock.class_)} of {base.element(stock.id).label}"
                self.extend(Element(name, stock.class_, label), stock.placement)


def stocks(view: WorldView) -> tuple[Stock, ...]:
    """Returns every stock that is not empty; malformed ones count as empty."""
    if STOCK not in view.ontology.classes:
        return ()
    found = (_stock(view, element) for element in view.instances(STOCK))
    return tuple(stock for stock in found if stock is not None)


def is_token(name: str) -> bool:
    """Returns whether a name stands for a thing that has no individual yet."""
    return _MARK in name


def by_stock(names: Iterable[str]) -> tuple[str, ...]:
    """Returns readable names: elements as they are, tokens as "2 of stock bolts_a"."""
    given = tuple(names)
    counted = Counter(name.partition(_MARK)[0] for name in given if is_token(name))
    own = (name for name in given if not is_token(name))
    return (*own, *(f"{number} of stock {stock}" for stock, number in counted.items()))


def take(tx: Transaction, token: str) -> str:
    """Creates an individual for a thing in stock, at the stock's place, and decrements the stock.

    Args:
        tx: The transaction to write to.
        token: The token of the thing.

    Returns:
        The id of the new element.

    Raises:
        WorldError: The stock is used up or gone.
    """
    name = token.partition(_MARK)[0]
    stock = _stock(tx.view, name) if tx.view.has(name) else None
    if stock is None:
        raise WorldError("nothing is left of stock {name}", name=name)
    tx.set(stock.id, STOCK_COUNT, stock.count - 1)
    return tx.add(stock.class_, placement=stock.placement)


def _stock(view: WorldView, element: str) -> Stock | None:
    class_, count = view.value(element, STOCK_OF), view.value(element, STOCK_COUNT)
    places = view.subjects(HAS_A, element)
    if not places or not isinstance(class_, str) or not isinstance(count, int) or count < 1:
        return None
    relation = IN if view.ontology.is_a(view.element(places[0]).type, CONTAINER) else ON
    return Stock(element, class_, count, Placement(relation, places[0]))
