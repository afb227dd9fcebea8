"""`farhand`: Django's command line for an installed portal, for example `farhand demo`."""

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
        from portal import forks  # noqa: PLC0415 - only the supervisor's

        forks.prepare()
    from django.core.management import execute_from_command_line  # noqa: PLC0415 - Django is slow to import

    execute_from_command_line(sys.argv)
