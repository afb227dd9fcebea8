"""The portal is served as soon as its web process answers, whatever it answers: behind a proxy it refuses our address."""

import asyncio
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from portal.management.commands.demo import _until_served
from tests.rig import free_port


@pytest.mark.parametrize("status", [200, 301, 400, 503])
def test_any_answer_counts(status):
    class Answer(BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(status)
            self.send_header("Location", "https://robots.example.org/livez")
            self.send_header("Content-Length", "0")
            self.end_headers()

        def log_message(self, *_):
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Answer) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        asyncio.run(asyncio.wait_for(_until_served("127.0.0.1", server.server_port), 10))
        server.shutdown()


def test_no_answer_does_not():
    with pytest.raises(TimeoutError):
        asyncio.run(asyncio.wait_for(_until_served("127.0.0.1", free_port()), 0.5))
