"""User and password of a network camera: given to the camera once it asks, by basic or digest authentication."""

import base64
import hashlib
import re
from collections.abc import Callable, Iterable
from typing import Any
from urllib.parse import SplitResult, unquote
from urllib.request import (
    AbstractDigestAuthHandler,
    HTTPPasswordMgrWithDefaultRealm,
    Request,
    parse_http_list,
    parse_keqv_list,
)

from robots.kit.contract.errors import CameraFault

HASHES = {"MD5": hashlib.md5, "SHA": hashlib.sha1, "SHA-256": hashlib.sha256}

SCHEME = re.compile(r"([A-Za-z][\w-]*)(?:\s++(?!=)|$)")  # followed by its values; a value's name by "="
PLACE = "http://camera"  # for Python's handler, which may know several


class _Digest(AbstractDigestAuthHandler):
    """Python's digest authentication (RFC 7616, qop auth or none), for names and passwords beyond ASCII too."""

    def get_algorithm_impls(self, algorithm: str) -> Any:
        """Return the functions H and KD of the RFC. Raises KeyError."""
        made = HASHES[algorithm.upper()]

        def hashed(text: str) -> str:
            return made(text.encode(), usedforsecurity=False).hexdigest()

        return hashed, lambda secret, data: hashed(f"{secret}:{data}")


class Login:
    """Makes the header `Authorization` of each request. Nothing is sent before the camera has asked for it."""

    def __init__(self, parts: SplitResult) -> None:
        """Take them from an address, where special characters are percent-encoded. Raises CameraFault."""
        self._user, self._password = unquote(parts.username or ""), unquote(parts.password or "")
        if not f"{self._user}{self._password}".isprintable() or '"' in self._user:
            raise CameraFault("The user or the password in the camera's address has a character that cannot be sent.")
        self.has_user = parts.username is not None
        self._made: Callable[[str], str | None] = lambda target: None

    def header(self, target: str) -> dict[str, bytes]:
        """Return the header of a GET of `target`, none as long as the camera has not asked for it."""
        made = self._made(target)
        return {} if made is None else {"Authorization": made.encode()}

    def challenged(self, challenges: Iterable[str]) -> bool:
        """Answer the headers `WWW-Authenticate` of a 401 from now on. Return False where there is nothing to answer."""
        if not self.has_user:
            return False
        schemes = _schemes(", ".join(challenges))
        for digest in [_read(values) for scheme, values in schemes if scheme == "digest"]:
            if _understood(digest):
                self._made = self._digest(digest)
                return True
        if any(scheme == "basic" for scheme, _ in schemes):
            token = base64.b64encode(f"{self._user}:{self._password}".encode()).decode()
            self._made = lambda target: f"Basic {token}"
            return True
        return False

    def _digest(self, challenge: dict[str, str]) -> Callable[[str], str | None]:
        passwords = HTTPPasswordMgrWithDefaultRealm()
        passwords.add_password(None, PLACE, self._user, self._password)
        handler = _Digest(passwords)
        told = challenge | ({"qop": "auth"} if "qop" in challenge else {})
        return lambda target: f"Digest {handler.get_authorization(Request(PLACE + target), told)}"  # noqa: S310 - not opened


def _schemes(challenges: str) -> list[tuple[str, list[str]]]:
    """Return each scheme with its values; several may stand in one header, and a quoted value may name one, too."""
    schemes: list[tuple[str, list[str]]] = []
    for item in parse_http_list(challenges):
        begins = SCHEME.match(item)
        if begins:
            schemes.append((begins[1].lower(), []))
            item = item[begins.end() :]
        if item and schemes:
            schemes[-1][1].append(item)
    return schemes


def _read(values: list[str]) -> dict[str, str]:
    """Return the values of a challenge by their names; nothing where they cannot be read."""
    try:
        return parse_keqv_list(values)
    except (ValueError, LookupError):
        return {}


def _understood(challenge: dict[str, str]) -> bool:
    qop = challenge.get("qop")
    plain = qop is None or "auth" in [each.strip() for each in qop.split(",")]
    return plain and {"realm", "nonce"} <= challenge.keys() and challenge.get("algorithm", "MD5").upper() in HASHES
