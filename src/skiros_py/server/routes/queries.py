"""Routes: queries."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response

from skiros_py.api.queries import Query, QueryAnswer
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.answers import CSV, TURTLE, answer_response
from skiros_py.server.routes.parameters import also_refused
from skiros_py.server.services import StationDep

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
def ask_question(question: Query, request: Request, station: StationDep) -> Response:
    """Answers SELECT, ASK or CONSTRUCT over ontology, scene, what was learned, and computed relations.

    Nothing can be changed by it. It runs in a process of its own: for `time_limit` at most, with 1 GiB of memory,
    10,000 rows and 16 MiB of answer; four at once, then 503. `Accept: text/csv` asks for the rows of a SELECT as CSV,
    `Accept: text/turtle` for the triples of a CONSTRUCT as Turtle.
    """
    return answer_response(station.ontology.query(question), request.headers.get("accept", ""))
