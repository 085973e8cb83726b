"""The use cases of a running cell, shared by command line, library and server."""
