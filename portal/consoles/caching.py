"""How long browsers keep what consoles are made of."""

from wsgiref.headers import Headers

STABLE = ("/static/farhand/", "/static/robots/")  # addresses that stay while what they lead to changes


def revalidate(headers: Headers, path: str, url: str) -> None:
    """Have browsers ask at each load whether a file under a stable address has changed."""
    if url.startswith(STABLE):
        headers["Cache-Control"] = "no-cache"
