"""Caching of console files in browsers."""

from wsgiref.headers import Headers

STABLE = ("/static/farhand/", "/static/robots/")  # addresses that stay while their content changes


def revalidate(headers: Headers, path: str, url: str) -> None:
    """Make browsers ask at each load whether a file at a stable address has changed."""
    if url.startswith(STABLE):
        headers["Cache-Control"] = "no-cache"
