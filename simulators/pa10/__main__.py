"""The museum arm as a process: ``python -m simulators.pa10 --dir DIR [--port N] [--controller pd] [--speed N]``.

In DIR it keeps `tty` (the address it listens at), `camera` and `cameras.json`, `faults` (a Unix socket),
`journal.jsonl`, `programs.json` and `scene.npy`.
"""

import os
import sys
from functools import partial

from robots.kit.clock import FasterTimer
from robots.kit.description import load
from simulators.common.arm.priority import first_in_line
from simulators.common.process import arguments, run
from simulators.common.threads import end_with_any
from simulators.pa10.controllers import CONTROLLERS
from simulators.pa10.planning import Planning
from simulators.pa10.simulator import Simulator

SWITCH_S = 2e-4  # the longest time for another thread; Python's default of 5 ms is two and a half steps


def main() -> None:
    """Run the simulator."""
    end_with_any()
    line = load("pa10")["line"]
    parser = arguments(__doc__)
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--controller", choices=sorted(CONTROLLERS), default="computed_torque")
    parser.add_argument("--watchdog", type=float, default=line["watchdog_s"])
    parser.add_argument("--nobody", type=float, default=line["connect_s"])
    options = parser.parse_args()
    token = os.environ.get("PA10_TOKEN", "")
    watchdog, clock = (options.watchdog, options.nobody), FasterTimer(options.speed)
    planner = partial(Planning, forked=True)
    simulator = Simulator(options.dir, planner, options.controller, token, watchdog, clock)
    port = simulator.open(options.port)
    sys.setswitchinterval(SWITCH_S)
    first_in_line()
    run(simulator, f"listening on 127.0.0.1:{port}")


if __name__ == "__main__":
    main()
