"""The table: it turns at its pace, which takes half a second to change, or as long as its environment says."""

import argparse
import json
import os
import socketserver
import threading
import time
from pathlib import Path

PACE = 1.0  # rad/s
TAKES_S = float(os.environ.get("TURNTABLE_TAKES_S", "0.5"))
CELLS = 63  # of the circle, a tenth of a radian each: where the table has pointed


class Table:
    def __init__(self):
        self.start = self.goal = 0.0
        self.pace = PACE
        self.began, self.held = time.monotonic(), False
        self.lock = threading.Lock()
        self.trail = bytearray(CELLS)

    def angle(self):
        way = self.goal - self.start
        done = min(abs(way), self.pace * (time.monotonic() - self.began))
        return self.start + (done if way > 0 else -done)

    def take(self, said):
        if said["do"] == "pace":
            time.sleep(TAKES_S)
        with self.lock:
            here = self.angle()
            if said["do"] == "pace":
                self.start, self.began, self.pace = here, time.monotonic(), said["pace"]
            if said["do"] == "turn":
                self.start, self.goal, self.began, self.held = here, said["angle"], time.monotonic(), False
            elif said["do"] == "hold":
                self.held = self.held or abs(here - self.goal) > 1e-6
                self.start = self.goal = here
            here = self.angle()
            cell = int((here + 3.15) * 10)
            self.trail[cell] = min(self.trail[cell] + 1, 255)
            return {
                "trail": self.trail.hex(),
                "angle": here,
                "moving": abs(here - self.goal) > 1e-6,
                "held": self.held,
                "pace": self.pace,
                "warmth": 20.0 + min(abs(here), 9.0),
            }


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--dir", type=Path, required=True)
    folder = parser.parse_args().dir
    folder.mkdir(parents=True, exist_ok=True)
    table, at = Table(), folder / "line"
    at.unlink(missing_ok=True)

    class Line(socketserver.StreamRequestHandler):
        def handle(self):
            self.wfile.write(json.dumps(table.take(json.loads(self.rfile.readline()))).encode() + b"\n")

    server = socketserver.ThreadingUnixStreamServer(str(at), Line)
    server.daemon_threads = True
    (folder / "tty").write_text(f"{at}\n")
    server.serve_forever()


if __name__ == "__main__":
    main()
