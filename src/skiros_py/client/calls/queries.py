"""Questions in SPARQL."""

from __future__ import annotations

from httpx2 import Response
from pydantic import TypeAdapter

from skiros_py.api.queries import AskAnswer, ConstructAnswer, Query, QueryAnswer, SelectAnswer
from skiros_py.client.call import Call

_ANSWER: TypeAdapter[SelectAnswer | AskAnswer | ConstructAnswer] = TypeAdapter(QueryAnswer)


def ask_question(question: Query) -> Call[SelectAnswer | AskAnswer | ConstructAnswer]:
    """Answers SELECT, ASK or CONSTRUCT."""
    return Call("POST", "/queries", _answer, json=question.model_dump(mode="json"))


def _answer(response: Response) -> SelectAnswer | AskAnswer | ConstructAnswer:
    return _ANSWER.validate_python(response.json())
