"""Places of a camera's viewers when the system has no thread left."""

import http.client
import threading
from http.server import BaseHTTPRequestHandler

from simulators.common.camera_server import MOST_VIEWERS, Server
from tests.waiting import CEILING_S


class Handler(BaseHTTPRequestHandler):
    timeout = CEILING_S

    def do_GET(self):
        self.send_response(200)
        self.send_header("Content-Length", "0")
        self.end_headers()

    def log_message(self, *args):
        pass


class Quiet(Server):
    """Its errors are what the test makes."""

    errors = 0

    def handle_error(self, request, client_address):
        self.errors += 1


def ask(server):
    line = http.client.HTTPConnection(*server.server_address, timeout=CEILING_S)
    try:
        line.request("GET", "/", headers={"Connection": "close"})
        return line.getresponse().status
    except (http.client.HTTPException, ConnectionError):
        return 0
    finally:
        line.close()


def test_viewers_for_whom_no_thread_could_start_take_no_place(monkeypatch):
    server, real = Quiet(("127.0.0.1", 0), Handler), threading.Thread.start
    serving = threading.Thread(target=server.serve_forever, args=(0.05,))
    serving.start()

    def start(thread):
        raise RuntimeError("can't start new thread")

    try:
        monkeypatch.setattr(threading.Thread, "start", start)
        assert [ask(server) for _ in range(MOST_VIEWERS + 1)] == [0] * (MOST_VIEWERS + 1)
        monkeypatch.setattr(threading.Thread, "start", real)
        assert ask(server) == 200
        assert server.errors == MOST_VIEWERS + 1
    finally:
        server.shutdown()
        serving.join()
        server.server_close()
