"""`make wheel`, then `farhand demo` away from the clone, beside a robot's package that was installed too."""

import os
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request
import zipfile
from pathlib import Path

import pytest

from tests.environment import ROOT
from tests.rig import free_port

UV = Path(sys.executable).parent / "uv"
# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

RUN = "import sys; sys.path.insert(0, {site!r}); sys.argv[0] = 'farhand'; from portal.command import main; main()"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Return a folder with the wheels of portal and turntable unpacked: nothing in it comes from the clone."""
    built, site = tmp_path_factory.mktemp("built"), tmp_path_factory.mktemp("site")
    for source in (ROOT, ROOT / "tests" / "packages" / "turntable"):
        subprocess.run([UV, "build", "-q", "--system-certs", "--wheel", "--out-dir", built, source], check=True)
    subprocess.run([UV, "pip", "install", "-q", "--no-deps", "--target", site, *built.glob("*.whl")], check=True)
    return site


def test_the_wheel_holds_what_no_import_finds(site):
    for path in (
        "portal/shipped/templates/base.html", "portal/shipped/frontend/.vite/manifest.json",
        "portal/shipped/frontend/farhand/v1/console.js", "portal/shipped/frontend/farhand/v1/arm.css", "robots/kit/drivers/pa10/model.urdf",
        "robots/kit/drivers/mercury/console/console.html", "robots/migrations/0001_initial.py", "portal/static/portal/icon.svg",
    ):  # fmt: skip
        assert (site / path).is_file(), path
    assert not list(site.rglob("*.ts")), "what was built needs no source"
    assert not (site / "tests").exists()


def get(address):
    try:
        with urllib.request.urlopen(address, timeout=60) as answer:
            return answer.status, answer.read().decode()
    except (urllib.error.URLError, OSError) as error:
        return getattr(error, "code", 0), ""


def test_the_demo_of_an_installed_portal_serves_robots_and_consoles(site, tmp_path):
    away, home, port = tmp_path / "away", tmp_path / "home", free_port()
    for name in ("robots", "portal"):  # the author of a robot may have folders of these names beside it
        (away / name).mkdir(parents=True)
        (away / name / "__init__.py").touch()
    home.mkdir()
    clean = {k: v for k, v in os.environ.items() if not k.startswith(("FARHAND", "DJANGO", "REDIS", "DATABASE", "SECRET", "XDG"))}  # fmt: skip
    run = [sys.executable, "-P", "-c", RUN.format(site=str(site)), "demo", "--port", str(port)]
    with (tmp_path / "log").open("wb") as log:
        demo = subprocess.Popen(run, cwd=away, env={**clean, "HOME": str(home)}, stdout=log, stderr=log)
    try:
        base, until = f"http://127.0.0.1:{port}", time.monotonic() + 120
        while get(f"{base}/livez")[0] != 200:
            assert demo.poll() is None and time.monotonic() < until, (tmp_path / "log").read_text()
            time.sleep(0.5)
        for page in (
            "/",
            "/robots/mercury/",
            "/robots/museum-arm/",
            "/classic/mercury/",
            "/static/farhand/v1/console.js",
        ):
            assert get(base + page)[0] == 200, page
        assert "/static/app/assets/" in get(f"{base}/robots/mercury/")[1]
        assert get(f"{base}/static/robots/turntable/console.js")[0] == 200
        assert (home / ".local/share/farhand/farhand.sqlite3").is_file()
        assert not list(away.glob("*.sqlite3"))
    finally:
        demo.send_signal(signal.SIGINT)
        demo.wait(60)


def test_a_wheel_is_no_larger_than_a_download_may_be(site, tmp_path):
    subprocess.run([UV, "build", "-q", "--system-certs", "--wheel", "--out-dir", tmp_path, ROOT], check=True)
    (made,) = tmp_path.glob("*.whl")
    assert zipfile.ZipFile(made).testzip() is None
    assert made.stat().st_size < 5_000_000
