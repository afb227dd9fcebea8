"""The cart: one metre a second; a metre costs a fifth of the battery, the dock at 0 fills it in a second."""

import argparse
import json
import socketserver
import threading
import time
from pathlib import Path

SPEED, COST, FILL = 1.0, 0.2, 1.0


class Cart:
    def __init__(self, journal):
        self.x, self.goal, self.battery, self.held, self.doing = 0.0, 0.0, 1.0, False, ""
        self.rail, self.driven = 1, 0.0
        self.lock, self.seen, self.journal = threading.Lock(), time.monotonic(), journal

    def _pass(self):
        now = time.monotonic()
        step, self.seen = now - self.seen, now
        way = min(abs(self.goal - self.x), SPEED * step)
        self.x += way if self.goal > self.x else -way
        self.driven += way
        self.battery = max(0.0, self.battery - COST * way)
        if self.doing == "dock" and self.x == self.goal:
            self.battery = min(1.0, self.battery + FILL * step)
        if self.doing == "roam" and self.x == self.goal:
            self.goal = 2.0 if self.x < 1.0 else 0.0

    @property
    def moving(self):
        return self.doing == "roam" or self.x != self.goal or (self.doing == "dock" and self.battery < 1.0)

    def take(self, said):
        with self.lock:
            self._pass()
            if said["do"] == "hold":
                self.held, self.goal, self.doing = self.held or self.moving, self.x, ""
            elif said["do"] == "new_rail":  # by whoever stands beside it
                self.rail += 1
            elif said["do"] != "state":
                self.goal = said["x"] if said["do"] == "go" else 0.0
                self.doing, self.held = said["do"], False
                with self.journal.open("a") as out:
                    out.write(json.dumps(said | {"battery": round(self.battery, 3)}) + "\n")
            return {
                "x": self.x, "moving": self.moving, "held": self.held, "battery": self.battery, "rail": self.rail,
                "driven": self.driven,
            }  # fmt: skip


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--dir", type=Path, required=True)
    folder = parser.parse_args().dir
    folder.mkdir(parents=True, exist_ok=True)
    cart, at = Cart(folder / "journal.jsonl"), folder / "line"
    at.unlink(missing_ok=True)

    class Line(socketserver.StreamRequestHandler):
        def handle(self):
            self.wfile.write(json.dumps(cart.take(json.loads(self.rfile.readline()))).encode() + b"\n")

    server = socketserver.ThreadingUnixStreamServer(str(at), Line)
    server.daemon_threads = True
    (folder / "tty").write_text(f"{at}\n")
    server.serve_forever()


if __name__ == "__main__":
    main()
