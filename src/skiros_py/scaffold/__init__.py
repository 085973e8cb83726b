"""Generates packages and their contents: from a few options of the author to working, tested code."""
