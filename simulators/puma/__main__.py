"""The PUMA 560 as a process.

``python -m simulators.puma --dir DIR [--tcp PORT] [--baud 9600|38400] [--seed N] [--speed FACTOR]``

In DIR it keeps `tty` (the serial line, or with --tcp the address of a serial server), `cameras.json` and `camera` (the
addresses of its cameras), `faults` and `camera_faults` (Unix sockets), `journal.jsonl`, `state.json`, `scene.npy`,
`scene.mem` and `seed`.
"""

import sys
from functools import partial

from robots.kit.clock import FasterTimer
from robots.kit.description import load
from simulators.common.arm.priority import first_in_line
from simulators.common.process import arguments, run
from simulators.common.serial_line import line_opener
from simulators.common.threads import end_with_any
from simulators.puma import cameras
from simulators.puma.planning import Planning
from simulators.puma.simulator import Simulator

SWITCH_S = 2e-4  # the longest time for another thread; Python's default of 5 ms is two and a half steps


def main() -> None:
    """Run the simulator."""
    end_with_any()
    parser = arguments(__doc__)
    parser.add_argument("--seed", type=int, help="of the cell's hidden errors; without it, the one of the folder")
    parser.add_argument("--tcp", type=int)
    parser.add_argument("--baud", type=int, default=load("puma")["line"]["baud"], help="of the line; 9600 or 38400")
    options = parser.parse_args()
    clock = FasterTimer(options.speed)

    opened = line_opener(options.baud, options.tcp, clock)
    simulator = Simulator(options.dir, partial(Planning, forked=True), opened, options.seed, clock)
    simulator.open(cameras.run)
    sys.setswitchinterval(SWITCH_S)
    first_in_line()
    run(simulator, f"line {(options.dir / 'tty').resolve()}")


if __name__ == "__main__":
    main()
