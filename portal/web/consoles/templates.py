"""Templates of robots: `consoles/<driver>/<name>.html` is the file of that name in the robot's folder `console`."""

import re
from collections.abc import Iterator

from django.template import Origin, TemplateDoesNotExist
from django.template.loaders.base import Loader as BaseLoader

from robots.kit.description import folder

NAME = re.compile(r"consoles/([a-z0-9_]{1,60})/([a-z0-9_]{1,60}\.html)\Z")


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
