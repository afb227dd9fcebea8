"""The files of robots' consoles, read from the robots' packages: static files and templates.

`/static/robots/<driver>/<file>` is the static file `console/<file>` of another package. The template
`consoles/<driver>/<name>.html` is `console/<name>.html` of any robot.
"""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from django.contrib.staticfiles.finders import BaseFinder
from django.core.files.storage import FileSystemStorage
from django.template import Origin, TemplateDoesNotExist
from django.template.loaders.base import Loader as BaseLoader

from robots.kit.description import folder
from robots.kit.installed import packaged

SERVED = frozenset({".js", ".css", ".json", ".map", ".svg", ".png", ".jpg", ".webp", ".glb", ".woff2", ".wasm"})
NAME = re.compile(r"consoles/([a-z0-9_]{1,60})/([a-z0-9_]{1,60}\.html)\Z")


def folders() -> Iterator[tuple[str, Path]]:
    """Yield (driver, folder) of each installed robot that ships a console."""
    for driver in packaged():
        try:
            kept = Path(str(folder(driver).joinpath("console")))
        except ImportError:
            continue  # its robot's page says that the package is broken
        if kept.joinpath("console.js").is_file():
            yield driver, kept


class Finder(BaseFinder):
    """Finds the console files of installed robot packages, and no other files of them."""

    def check(self, **kwargs: Any) -> list[Any]:
        """Return no errors: there are no settings."""
        return []

    def list(self, ignore_patterns: Iterable[str] | None) -> Iterator[tuple[str, FileSystemStorage]]:
        """Yield (path, storage) of each file."""
        for driver, kept in folders():
            storage = FileSystemStorage(location=kept)
            storage.prefix = f"robots/{driver}"  # type: ignore[attr-defined]
            for file in sorted(kept.rglob("*")):
                if file.suffix in SERVED and file.is_file():
                    yield file.relative_to(kept).as_posix(), storage

    def find(self, path: str, find_all: bool = False, **kwargs: Any) -> Any:
        """Return the file's path, or with `find_all` the list of paths; an empty list if there is none."""
        for at, storage in self.list(None):
            if f"{storage.prefix}/{at}" == Path(path).as_posix():  # type: ignore[attr-defined]
                return [storage.path(at)] if find_all else storage.path(at)
        return []


class Loader(BaseLoader):
    """Reads templates from the robot's package, wherever it is installed."""

    def get_template_sources(self, template_name: str) -> Iterator[Origin]:
        """Yield the place of the template, if there is one."""
        if NAME.match(str(template_name)):
            yield Origin(name=f"robot:{template_name}", template_name=template_name, loader=self)

    def get_contents(self, origin: Origin) -> str:
        """Return the text. Raises TemplateDoesNotExist."""
        found = NAME.match(str(origin.template_name))
        assert found is not None
        try:
            return folder(found[1]).joinpath("console", found[2]).read_text("utf-8")
        except (ImportError, OSError) as error:
            raise TemplateDoesNotExist(origin) from error
