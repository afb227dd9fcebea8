"""`manage.py conform DRIVER`: try a driver against everything that the portal asks of it."""

import os
from argparse import ArgumentParser
from pathlib import Path
from typing import Any

from django.core.management.base import BaseCommand, CommandError

from robots.kit.addresses import AddressError, check_robot
from robots.kit.conformance.installed import conform_installed
from robots.kit.conformance.report import Result
from robots.kit.conformance.simulated import NotStarted
from robots.kit.conformance.suite import CHECKS
from robots.kit.installed import simulators

MOVES = (
    "The suite moves the robot to the ends of its ranges and stops it on its way. Clear its workspace, have its "
    "emergency stop at hand, stop the robot's worker, and add --moves."
)


class Command(BaseCommand):
    """The conformance suite."""

    help = "Runs the conformance suite over an installed driver, on its simulator or on a robot."
    requires_system_checks: list[str] = []

    def add_arguments(self, parser: ArgumentParser) -> None:
        """Take the driver's name and its address."""
        parser.add_argument("driver", help="its name, as in the entry point farhand.drivers")
        parser.add_argument("--address", default="", help="sim:NAME (the default: its simulator), serial:… or tcp:…")
        parser.add_argument("--moves", action="store_true", help="a real robot may be moved")
        parser.add_argument(
            "--only", action="append", default=[], choices=list(CHECKS), help="a check; may be repeated"
        )
        parser.add_argument(
            "--speed", dest="factor", type=float, default=1.0, help="how many times faster a simulator runs"
        )
        parser.add_argument("--epoch", type=int, default=1, help="the fencing epoch of the sessions")
        parser.add_argument("--json", type=Path, help="a file that gets the report, too")

    def handle(self, *args: Any, **options: Any) -> None:
        """Run it; the exit status is 1 if a check failed."""
        name, address = options["driver"], self._address(options)
        kind = address.partition(":")[0]
        self.stdout.write(f"{name} at {address}{', a simulator that is started for it' if kind == 'sim' else ''}.\n")
        try:
            report = conform_installed(
                name, address, factor=options["factor"], epoch=options["epoch"], only=options["only"], told=self._tell,
                token=os.environ.get(f"FARHAND_TOKEN_{name.upper().replace('-', '_')}", ""),
            )  # fmt: skip
        except (LookupError, NotStarted) as error:
            raise CommandError(f"{str(error)[:1].upper()}{str(error)[1:]}.") from error
        self.stdout.write(f"\n{report.text()}")
        if options["json"]:
            options["json"].write_text(report.as_json())
        if report.failures:
            raise CommandError(f"{len(report.failures)} of {len(report.results)} checks failed.", returncode=1)

    def _address(self, options: dict[str, Any]) -> str:
        name, address = options["driver"], options["address"]
        if not address:
            if name not in simulators():
                raise CommandError(f"No simulator named {name!r} is installed: give --address serial:… or tcp:….")
            return f"sim:{name}"
        try:
            check_robot(address)
        except AddressError as error:
            raise CommandError(str(error)) from error
        if not address.startswith("sim:") and not options["moves"]:
            raise CommandError(MOVES)
        return str(address)

    def _tell(self, result: Result) -> None:
        """Tell that a check is over, because all of them take minutes."""
        if self.stdout.isatty():
            self.stdout.write(f"{result.check}: {result.verdict}\n")
