"""The hall rover as a process.

``python -m simulators.srv1 --dir DIR [--port N] [--seed N] [--speed N] [--link wifi|radio|internet] [--stock]
[--beacon]``

In DIR it keeps `tty` (the address of its port), `overhead` (the address of the view from above, which is for people and
tests, never for the rover), `faults` (a Unix socket), `journal.jsonl`, `state.json` and `flash`.
"""

import gc
import sys

from robots.kit.clock import FasterTimer
from simulators.common.process import arguments, stop_when_told
from simulators.common.threads import end_with_any
from simulators.srv1.simulator import LINKS, Simulator


def main() -> None:
    """Run the simulator."""
    end_with_any()
    parser = arguments(__doc__)
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument(
        "--seed", type=int, default=1, help="of noise, of the air and of everything else that is random"
    )
    parser.add_argument(
        "--link", choices=LINKS, default=LINKS[0],
        help="radio: 7 kbit/s, 37 ms a cycle; internet: 70 to 120 ms each way, by the seed",
    )  # fmt: skip
    parser.add_argument("--stock", action="store_true", help="the published letters alone: it is silent to the rest")
    parser.add_argument("--beacon", action="store_true", help="the tower tells the rover range and bearing")
    options = parser.parse_args()
    clock = FasterTimer(options.speed)
    simulator = Simulator(
        options.dir, options.seed, clock, stock=options.stock, link=options.link, beacon=options.beacon
    )
    port = simulator.open(options.port)
    stop_when_told(simulator)
    sys.stdout.write(f"SRV-1 at socket://127.0.0.1:{port}\n")
    sys.stdout.flush()
    gc.collect()
    gc.freeze()
    simulator.run()


if __name__ == "__main__":
    main()
