"""`manage.py restore FILE`: loads a backup into an empty portal, and compares."""

from pathlib import Path
from typing import Any

from django.core.management import call_command
from django.core.management.base import BaseCommand, CommandError, CommandParser

from portal.keep.archive import ArchiveError
from portal.keep.restore import read


class Command(BaseCommand):
    """Load a backup."""

    help = "Load a backup; stop the portal first. Row counts and the pictures' hashes are compared."

    def add_arguments(self, parser: CommandParser) -> None:
        """Add the file argument."""
        parser.add_argument("file", type=Path)
        parser.add_argument("--replace", action="store_true", help="delete what this portal contains now")

    def handle(self, *args: Any, **options: Any) -> None:
        """Migrate, load, compare."""
        call_command("migrate", verbosity=0, interactive=False)
        try:
            manifest = read(options["file"], options["replace"])
        except ArchiveError as error:
            raise CommandError(str(error)) from error
        rows, media = sum(manifest["rows"].values()), len(manifest["media"])
        self.stdout.write(
            f"restored {rows} rows and {media} pictures and recordings of {manifest['made_at']}; counts and hashes "
            "are equal. Open turns were ended; robots are put in order before anybody drives them."
        )
