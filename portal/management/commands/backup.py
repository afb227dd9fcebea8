"""`manage.py backup FILE`: writes all rows and pictures to one file, while the portal runs."""

from pathlib import Path
from typing import Any

from django.core.management.base import BaseCommand, CommandError, CommandParser

from portal.keep.archive import ArchiveError, write


class Command(BaseCommand):
    """Write a backup."""

    help = "Write rows and pictures to one file; the portal may go on meanwhile."

    def add_arguments(self, parser: CommandParser) -> None:
        """Add the file argument."""
        parser.add_argument("file", type=Path)
        parser.add_argument("--without-recordings", action="store_true", help="leave out the files of recordings")

    def handle(self, *args: Any, **options: Any) -> None:
        """Write the backup, and print how much it contains."""
        try:
            manifest = write(options["file"], not options["without_recordings"])
        except ArchiveError as error:
            raise CommandError(str(error)) from error
        rows, media = sum(manifest["rows"].values()), len(manifest["media"])
        self.stdout.write(f"{options['file']}: {rows} rows, {media} pictures and recordings. Sessions are left out.")
