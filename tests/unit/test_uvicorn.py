"""Our protocols override methods that uvicorn does not promise to keep: a version that changes one is read first."""

import hashlib
import inspect

import pytest
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol, RequestResponseCycle
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from portal.edge.protocols import Http
from portal.edge.sockets import Ws

# The digest of each method as it was when ours was written for it. A difference names the methods to read in uvicorn:
# does ours still fit? Then its new digest stands here.
READ = {
    "HttpToolsProtocol.__init__": "eefda6875ebd",
    "HttpToolsProtocol._should_upgrade": "33b213065ffa",
    "HttpToolsProtocol._unset_keepalive_if_required": "df160182c46a",
    "HttpToolsProtocol.connection_lost": "1b99df458c3b",
    "HttpToolsProtocol.connection_made": "c8b2230c91b4",
    "HttpToolsProtocol.data_received": "e74b210e3c04",
    "HttpToolsProtocol.handle_websocket_upgrade": "ecdf04e7e953",
    "HttpToolsProtocol.on_body": "a02fa52bdf33",
    "HttpToolsProtocol.on_header": "b89cbbc6db2a",
    "HttpToolsProtocol.on_headers_complete": "f48ec6bbe75d",
    "HttpToolsProtocol.on_message_begin": "453ed691ca9d",
    "HttpToolsProtocol.on_message_complete": "87e5be1faf50",
    "HttpToolsProtocol.on_response_complete": "4dfe4f257f50",
    "HttpToolsProtocol.pause_writing": "942adeb76e2e",
    "HttpToolsProtocol.resume_writing": "5211cfcc7289",
    "RequestResponseCycle.__init__": "f882611e893b",
    "RequestResponseCycle.receive": "e7a392a4367a",
    "RequestResponseCycle.run_asgi": "0a5f7f242f6a",
    "RequestResponseCycle.send": "089bd8725f6a",
    "WebSocketsSansIOProtocol.__init__": "cc3743003c5d",
    "WebSocketsSansIOProtocol.connection_lost": "ce047f777be7",
    "WebSocketsSansIOProtocol.connection_made": "0c2167e3a06f",
    "WebSocketsSansIOProtocol.data_received": "9c7fd5fc30fd",
    "WebSocketsSansIOProtocol.handle_close": "d5e54a1357be",
    "WebSocketsSansIOProtocol.handle_connect": "9ed337a10dd4",
    "WebSocketsSansIOProtocol.handle_cont": "2b42372447d8",
    "WebSocketsSansIOProtocol.handle_parser_exception": "604f5a7a2d5c",
    "WebSocketsSansIOProtocol.handle_ping": "f1c52319c847",
    "WebSocketsSansIOProtocol.handle_pong": "83b7262e3938",
    "WebSocketsSansIOProtocol.keepalive_timeout": "8bb5001e0b27",
    "WebSocketsSansIOProtocol.on_task_complete": "447e06c8c214",
    "WebSocketsSansIOProtocol.pause_writing": "b50d4b2b8890",
    "WebSocketsSansIOProtocol.receive": "76b096e89551",
    "WebSocketsSansIOProtocol.resume_writing": "f589de175c67",
    "WebSocketsSansIOProtocol.run_asgi": "9e503eb7c050",
    "WebSocketsSansIOProtocol.send": "0f5eebb35c44",
    "WebSocketsSansIOProtocol.shutdown": "ba98819a4e60",
    "WebSocketsSansIOProtocol.send_receive_event_to_app": "6e70462ac67d",
}
ALSO_USED = (
    (HttpToolsProtocol, ("_unset_keepalive_if_required", "_should_upgrade")),
    (RequestResponseCycle, ("__init__", "run_asgi", "send", "receive")),
    (WebSocketsSansIOProtocol, ("__init__", "run_asgi", "receive")),
)


def digest(method):
    """Return the digest of a method's text, whatever its white space."""
    code = "".join(inspect.getsource(method).split())
    return hashlib.sha256(code.encode()).hexdigest()[:12]


def present():
    """Return the digests of all methods of uvicorn that ours override or rely on."""
    overridden = [(base, name) for ours, base in ((Http, HttpToolsProtocol), (Ws, WebSocketsSansIOProtocol))
                  for name, value in vars(ours).items() if inspect.isfunction(value) and inspect.isfunction(vars(base).get(name))]  # fmt: skip
    used = [(base, name) for base, names in ALSO_USED for name in names]
    return {f"{base.__name__}.{name}": digest(vars(base)[name]) for base, name in overridden + used}


def test_uvicorn_is_the_one_for_which_our_protocols_were_written():
    now = present()
    changed = sorted(name for name in READ.keys() | now.keys() if READ.get(name) != now.get(name))
    assert not changed, f"read these methods of uvicorn, then write their digests into this file: {changed}"


@pytest.mark.parametrize("name", ["Http", "Ws"])
def test_much_of_each_protocol_is_compared(name):
    base = {"Http": "HttpToolsProtocol", "Ws": "WebSocketsSansIOProtocol"}[name]
    assert sum(key.startswith(base) for key in READ) >= 10
