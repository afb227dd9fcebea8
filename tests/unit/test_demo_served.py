"""The portal is served as soon as its web process answers, whatever it answers; a port that is taken is said before."""

import asyncio
import socket
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest
from django.core.management import CommandError, call_command

from portal.management.commands.demo import _until_served
from tests.rig import free_port
from tests.waiting import CEILING_S


@pytest.mark.parametrize("status", [200, 301, 400, 503])
def test_any_answer_counts_of_a_host_that_is_ours(status, settings):
    settings.ALLOWED_HOSTS, hosts = [".example.org"], []

    class Answer(BaseHTTPRequestHandler):
        def do_GET(self):
            hosts.append(self.headers["Host"])
            self.send_response(status)
            self.send_header("Location", "https://robots.example.org/livez")
            self.send_header("Content-Length", "0")
            self.end_headers()

        def log_message(self, *_):
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Answer) as server:
        threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
        asyncio.run(asyncio.wait_for(_until_served("127.0.0.1", server.server_port), CEILING_S))
        server.shutdown()
    assert set(hosts) == {"example.org"}


def test_no_answer_does_not():
    with pytest.raises(TimeoutError):
        asyncio.run(asyncio.wait_for(_until_served("127.0.0.1", free_port()), 0.5))


def test_a_port_that_is_taken_is_named_and_how_to_choose_another(settings):
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        taken = other.getsockname()[1]
        with pytest.raises(CommandError, match=f"Port {taken} .* make run PORT="):
            call_command("demo", port=taken)
        settings.OPERATORS_PORT = taken
        with pytest.raises(CommandError, match=f"Port {taken} .* FARHAND_OPERATORS_PORT="):
            call_command("demo", port=free_port())
    settings.OPERATORS_PORT = port = free_port()
    with pytest.raises(CommandError, match="another port than the portal's"):
        call_command("demo", port=port)
