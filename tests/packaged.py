"""Install a robot's package for a test, as `pip install` would: on the path of this process and of its children."""

import os
import shutil
import sys
from contextlib import contextmanager
from pathlib import Path

TURNTABLE = Path(__file__).resolve().parent / "packages" / "turntable"
SHUTTLE, ERRANDS = TURNTABLE.with_name("shuttle"), TURNTABLE.with_name("errands")


@contextmanager
def installed_from(folder, monkeypatch):
    """Have the package in `folder` installed until the end."""
    from robots.kit import description
    from robots.kit import installed as packages
    from robots.kit.contract import find

    monkeypatch.syspath_prepend(str(folder))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")]))
    caches = (description.folder, description.load, find.spec_of, find.function, packages._named)
    for cache in caches:
        cache.cache_clear()
    yield
    for cache in caches:
        cache.cache_clear()
    for name in [n for n, module in list(sys.modules.items()) if str(folder) in str(getattr(module, "__file__", ""))]:
        del sys.modules[name]  # another test's package of that name is another one


def with_console(into, text):
    """Return a folder with the same package, whose `console.html` is that text."""
    folder = shutil.copytree(TURNTABLE, into, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "turntable_robot" / "console" / "console.html").write_text(text)
    return folder


def without_console(into):
    """Return a folder with the same package, which ships no console."""
    return shutil.copytree(TURNTABLE, into, ignore=shutil.ignore_patterns("console", "__pycache__"))


def of_spec(folder, name, spec):
    """Write the package of a robot into the folder, which has that text as its spec and no driver. Return the folder."""
    package, info = folder / f"{name}_robot", folder / f"{name}-1.dist-info"
    package.mkdir()
    info.mkdir()
    (package / "__init__.py").write_text("")
    (package / "spec.py").write_text(spec)
    (package / "robot.toml").write_text("")
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1\n")
    (info / "entry_points.txt").write_text(f"[farhand.drivers]\n{name} = {name}_robot.driver:Driver\n")
    return folder
