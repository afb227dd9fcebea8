"""`farhand`: Django's command line for an installed portal, for example `farhand demo`."""

import argparse
import os
import sys
from importlib.metadata import version


def main() -> None:
    """Run a management command."""
    os.environ.setdefault("DJANGO_SETTINGS_MODULE", "portal.settings")
    if sys.argv[1:] in (["--version"], ["version"]):
        sys.stdout.write(f"farhand {version('farhand')}\n")
        return
    if sys.argv[1:2] == ["demo"]:
        from portal.run import forks  # noqa: PLC0415 - only the supervisor's

        _note_port(sys.argv[2:])
        forks.prepare()
    from django.core.management import execute_from_command_line  # noqa: PLC0415 - Django is slow to import

    execute_from_command_line(sys.argv)


def _note_port(arguments: list[str]) -> None:
    """Put the port into the environment before the settings are read, which all forks share: mails link to it."""
    parser = argparse.ArgumentParser(add_help=False, exit_on_error=False)
    parser.add_argument("--port", type=int)
    try:
        port = parser.parse_known_args(arguments)[0].port
    except argparse.ArgumentError:
        return  # the command names the error
    if port is not None:
        os.environ["FARHAND_PORT"] = str(port)
