"""Every page of the portal by the name of its picture: for the pictures of `make shots`, and for axe.

What stands in braces is of a row that is made first; `new` is a robot for which the person has no clearance. The pages of the admin's models are in `tests/services/admin_pages.py`.
"""

from string import Formatter

PUBLIC = {
    "landing": "/", "story": "/story/", "status": "/status/", "statistics": "/statistics/", "log": "/log/",
    "movie-of-the-day": "/movie-of-the-day/", "mercury": "/robots/mercury/", "museum-arm": "/robots/museum-arm/",
    "irat": "/robots/irat/", "rover": "/robots/rover/", "puma": "/robots/puma/", "orientation": "/robots/mercury/orientation/",
    "practice": "/robots/{practice}/", "finds": "/robots/mercury/finds/", "jobs": "/robots/irat/jobs/", "statistics-of-jobs": "/robots/irat/statistics/",
    "recordings": "/robots/irat/recordings/", "classic": "/classic/mercury/", "turn": "/turns/{turn}/", "job": "/jobs/{job}/",
    "replay": "/recordings/{recording}/", "embedded-robot": "/embed/robots/mercury/",
    "embedded-replay": "/embed/recordings/{recording}/", "sign-in": "/accounts/login/", "sign-up": "/accounts/signup/",
    "reset": "/accounts/password/reset/", "reset-sent": "/accounts/password/reset/done/",
    "reset-key": "/accounts/password/reset/key/{reset}/", "reset-done": "/accounts/password/reset/key/done/",
    "confirmation-sent": "/accounts/confirm-email/", "confirmation": "/accounts/confirm-email/{confirmation}/",
    "inactive": "/accounts/inactive/", "nothing": "/nothing/",
}  # fmt: skip
OWN = {
    "me": "/me/", "read": "/robots/{new}/orientation/", "clearance": "/robots/{new}/clearance/", "email": "/accounts/email/",
    "password": "/accounts/password/change/", "sign-out": "/accounts/logout/", "sign-in-again": "/accounts/reauthenticate/",
}  # fmt: skip
STAFF = {"admin": "/admin/", "admin-robot": "/admin/robots/robot/{robot}/change/", "survey": "/survey/results/"}


def known(pages: dict[str, str], **rows: object) -> dict[str, str]:
    """Return the pages whose rows there are, with these rows in their addresses."""
    names = {page: {name for _, name, _, _ in Formatter().parse(address) if name} for page, address in pages.items()}
    return {page: address.format(**rows) for page, address in pages.items() if names[page] <= set(rows)}


def without(pages: dict[str, str], *robots: str) -> list[str]:
    """Return the addresses but those of these robots, and the one where nothing is."""
    return [address for address in pages.values() if not {"nothing", *robots} & set(address.split("/"))]
