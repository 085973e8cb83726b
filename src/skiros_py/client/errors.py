"""Errors of calls: the server refused, or does not answer."""

from __future__ import annotations

import httpx2
from pydantic import ValidationError

from skiros_py.api.problem import ProblemDetails
from skiros_py.errors import DeviceError, SkirosError

_LONGEST_SHOWN = 200
_LONGEST_NUMBER = 5


class ProblemError(SkirosError):
    """The server refused a request and gave the reason.

    Attributes:
        problem: The problem document.
        retry_after: When to retry [s]; None if not given.
    """

    def __init__(self, problem: ProblemDetails, retry_after: float | None = None) -> None:
        self.problem = problem
        self.retry_after = retry_after
        super().__init__(problem.detail or problem.title)

    @property
    def status(self) -> int:
        """The HTTP status: 404 for not found, 409 for a conflict with the current state, 412 for a stale version, …."""
        return self.problem.status

    @property
    def code(self) -> str:
        """The kind of problem, for programs ("UnknownJobOrderID"); empty if it did not come from a SkiROS server."""
        return self.problem.code

    @property
    def detail(self) -> str:
        """What is wrong with this request, and how to correct it."""
        return self.problem.detail


class Unreachable(DeviceError):
    """The server does not answer; whether a request that was sent took effect is unknown.

    Attributes:
        url: The URL that was tried.
    """

    def __init__(self, url: str, why: str) -> None:
        self.url = url
        super().__init__(
            f"no server answers at {url}: {why}; 'skiros serve SCENE --data DIR' starts one, and prints its address"
        )


class TookTooLong(SkirosError):
    """The awaited condition did not become true in time; it may later."""


def problem_of(response: httpx2.Response) -> ProblemError:
    """Parses the server's refusal; other responses (such as a proxy's) are shown as they are."""
    later = _retry_after(response)
    try:
        problem = ProblemDetails.model_validate_json(response.content)
        return ProblemError(problem.model_copy(update={"status": response.status_code}), later)
    except ValidationError:
        said = " ".join(response.text[:_LONGEST_SHOWN].split())
        title = f"{response.status_code} {response.reason_phrase}".rstrip()
        detail = f"{response.url} answered {title}{f': {said}' if said else ''}"
        return ProblemError(ProblemDetails(title=title, status=response.status_code, detail=detail), later)


def _retry_after(response: httpx2.Response) -> float | None:
    text = response.headers.get("retry-after", "").strip()
    return float(text) if text.isascii() and text.isdecimal() and len(text) <= _LONGEST_NUMBER else None
