"""The typed client of the REST API, for blocking and for asynchronous programs."""
