"""The hall rover as a process.

``python -m simulators.srv1 --dir DIR [--port N] [--seed N] [--speed N] [--link wifi|radio|internet] [--stock]
[--beacon]``

In DIR it keeps `tty` (the address of its port), `overhead` (the address of the view from above, which is for people and
tests, never for the rover), `faults` (a Unix socket), `journal.jsonl`, `state.json` and `flash`.
"""

from robots.kit.clock import FasterTimer
from simulators.common.process import arguments, run
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
    simulator = Simulator(
        options.dir, options.seed, FasterTimer(options.speed), stock=options.stock, link=options.link,
        beacon=options.beacon,
    )  # fmt: skip
    run(simulator, f"SRV-1 at {simulator.open(options.port)}")


if __name__ == "__main__":
    main()
