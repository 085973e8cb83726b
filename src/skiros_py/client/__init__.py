"""The typed client of the REST API, for blocking and for asynchronous programs."""

from skiros_py.client.async_client import AsyncClient
from skiros_py.client.client import Client
from skiros_py.client.errors import ProblemError, TookTooLong, Unreachable

__all__ = ["AsyncClient", "Client", "ProblemError", "TookTooLong", "Unreachable"]
