"""Routes: queries."""

from __future__ import annotations

from decimal import Decimal

from fastapi import APIRouter, Request, Response

from skiros_py.api.queries import Bound, DecimalLiteral, Query, QueryAnswer, TextLiteral
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.routes.parameters import also_refused
from skiros_py.server.services import ServicesDep
from skiros_py.server.world.answers import CSV, TURTLE, answer_response
from skiros_py.station.world.values import given
from skiros_py.world.queries import Binding, Text

__all__ = ["router"]

router = APIRouter(tags=["queries"])

_TEXT = {"schema": {"type": "string"}}


@router.post(
    "/queries",
    summary="Ask a question in SPARQL",
    dependencies=[needs(Role.ENGINEER)],
    response_model=QueryAnswer,
    responses={
        200: {"content": {CSV: _TEXT, TURTLE: _TEXT}},
        **also_refused(406, "The answer has no rows (text/csv), or no triples (text/turtle)."),
    },
)
def ask_question(question: Query, request: Request, services: ServicesDep) -> Response:
    """Answers SELECT, ASK or CONSTRUCT over ontology, scene, what was learned, and computed relations.

    Nothing can be changed by it. It runs in a process of its own: for `time_limit` at most, with 1 GiB of memory,
    10,000 rows and 16 MiB of answer; four at once, then 503. `Accept: text/csv` asks for the rows of a SELECT as CSV,
    `Accept: text/turtle` for the triples of a CONSTRUCT as Turtle.
    """
    bindings = {name: _binding(value) for name, value in question.bindings.items()}
    result = services.queries.answer(
        question.query, bindings, entailed=question.entailed, time_limit=question.time_limit
    )
    return answer_response(result, request.headers.get("accept", ""))


def _binding(value: Bound) -> Binding:
    if isinstance(value, TextLiteral):
        return Text(value.text)
    if isinstance(value, DecimalLiteral):
        return Decimal(value.decimal)
    return given(value)
