"""The typed client of the REST API, for blocking and for asynchronous programs."""

from skiros_py.client.client import AsyncClient, Client
from skiros_py.client.request import ProblemError, TookTooLong, Unreachable

__all__ = ["AsyncClient", "Client", "ProblemError", "TookTooLong", "Unreachable"]
