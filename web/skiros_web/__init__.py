"""The web user interface of skiros-py, as built pages: the server finds them by their entry point."""

from pathlib import Path

__all__ = ["PAGES"]

PAGES = Path(__file__).parent / "pages"
"""Folder of the built pages: ``index.html``, ``assets/`` and their compressed neighbours."""
