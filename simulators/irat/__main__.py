"""The iRat in its maze as a process.

``python -m simulators.irat --dir DIR [--port N] [--seed N] [--open-floor] [--speed N]``

In DIR it keeps `tty` (the address of its rosbridge), `overhead` (the address of the view from above, which is for
people and tests, never for the robot), `faults` (a Unix socket), `journal.jsonl` and `state.json`.
"""

from robots.kit.clock import FasterTimer
from simulators.common.process import arguments, run
from simulators.common.threads import end_with_any
from simulators.irat.simulator import Simulator


def main() -> None:
    """Run the simulator."""
    end_with_any()
    parser = arguments(__doc__)
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1, help="of noise, drift and everything else that is random")
    parser.add_argument("--open-floor", action="store_true", help="the dock alone, for trials of docking")
    options = parser.parse_args()
    simulator = Simulator(options.dir, options.seed, options.open_floor, FasterTimer(options.speed))
    run(simulator, f"rosbridge at {simulator.open(options.port)}")


if __name__ == "__main__":
    main()
