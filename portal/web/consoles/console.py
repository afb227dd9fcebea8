"""The console of a robot's page: its own, from the robot's folder, or a generic one drawn from the spec."""

from dataclasses import dataclass

from django.templatetags.static import static

from robots.kit.description import folder
from robots.kit.installed import package

OURS = "robots.kit.drivers."
PARTS = ("look", "screen", "buttons", "beside", "body")


@dataclass(frozen=True)
class Console:
    """The names of its templates, and its script: an entry of our front end, or the address of a file."""

    console: str
    side: str
    keys: str
    built: str = ""
    module: str = ""
    style: str = ""


PLAIN = Console("consoles/plain.html", "consoles/side.html", "consoles/keys.html", built="src/widgets/plain_console.ts")


def console_of(driver: str) -> Console:
    """Return the robot's console. Raises ImportError if its package is not installed.

    A robot that ships with Farhand has `console/console.ts`, which is built with our front end; a package of its own
    has `console/console.js`, which is served unchanged.
    """
    files = folder(driver).joinpath("console")
    served = files.joinpath("console.js").is_file()
    if not files.joinpath("console.html").is_file() or not (served or package(driver).startswith(OURS)):
        return PLAIN
    own = f"consoles/{driver}"
    side = f"{own}/side.html" if files.joinpath("side.html").is_file() else "consoles/no_side.html"
    keys = f"{own}/keys.html" if files.joinpath("keys.html").is_file() else PLAIN.keys
    if not served:
        built = f"../{package(driver).replace('.', '/')}/console/console.ts"
        return Console(f"{own}/console.html", side, keys, built=built)
    style = static(f"robots/{driver}/console.css") if files.joinpath("console.css").is_file() else ""
    return Console(f"{own}/console.html", side, keys, module=static(f"robots/{driver}/console.js"), style=style)


def classic(driver: str) -> str:
    """Return the name of the template with the buttons of the robot's classic console."""
    return f"consoles/{driver}/classic.html"


def parts(text: str, cut: str) -> dict[str, str]:
    """Return the parts of a console's rendered template by name; in it `cut` stands around each name.

    A console that does not extend that template has no parts: all of it is the body.
    """
    outside, *pieces = text.split(cut)
    found = dict(zip(pieces[::2], pieces[1::2], strict=False)) if pieces else {"body": outside}
    return {name: found.get(name, "").strip() for name in PARTS}
