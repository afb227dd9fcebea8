"""Screenshots of every page in both languages, wide and narrow, light and dark: part of `make shots`.

A demo with all its robots is started; a person drives, writes in the log and leaves, so that there is something to see.
"""

import io
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import product
from pathlib import Path

from PIL import Image

from tests.e2e.pages import OWN, PUBLIC, STAFF, known

PORT = 8791
TWIN = "mercury-practice"
LONGEST_PX = 6000
WEBP = {"format": "WEBP", "quality": 45, "method": 6}
LANGUAGES = {"en": "en-GB", "de": "de-DE"}
SIZES = {"wide": (1440, 900), "narrow": (390, 844)}
SCHEMES = ("light", "dark")
PEOPLE = """
from allauth.account.forms import default_token_generator
from allauth.account.models import EmailAddress, EmailConfirmationHMAC
from allauth.account.utils import user_pk_to_url_str
from accounts.models import Clearance, OrientationRead, User
from benchmarks.command_round_trip import cookie
from robots.kit.clock import SYSTEM
from robots.models import Robot
for name in ("ada", "staff"):
    user = User.objects.create_user(name, f"{name}@example.org", "correct horse 42")
    EmailAddress.objects.create(user=user, email=user.email, verified=True, primary=True)
    for robot in Robot.objects.exclude(slug="puma"):
        Clearance.objects.create(user=user, robot=robot, granted_at=SYSTEM.now())
    OrientationRead.objects.create(user=user, robot=Robot.objects.get(slug="puma"), at=SYSTEM.now())
User.objects.filter(username="staff").update(is_staff=True, is_superuser=True)
cy = User.objects.create_user("cy", "cy@example.org", "correct horse 42")
address = EmailAddress.objects.create(user=cy, email=cy.email, primary=True)
reset = f"{user_pk_to_url_str(cy)}-{default_token_generator.make_token(cy)}"
sessions = [cookie(User.objects.get(username=name)) for name in ("ada", "staff")]
print("people", *sessions, f"reset={reset}", f"confirmation={EmailConfirmationHMAC(address).key}")
"""


def main() -> None:
    """Take the pictures whose names are given, or all; the first argument is the folder."""
    from playwright.sync_api import sync_playwright

    folder, only = Path(sys.argv[1]), set(sys.argv[2:])
    with demo() as (url, person, staff, *keys), sync_playwright() as playwright:
        browsers = {locale: started(playwright, locale) for locale in LANGUAGES.values()}
        context = browsers["en-GB"].new_context(base_url=url, locale="en-GB")
        context.add_cookies([{"name": "sessionid", "value": person, "url": url}])
        rows = driven(context.new_page()) | dict(zip(("reset", "confirmation"), keys, strict=True)) | {"practice": TWIN}
        context.close()
        groups = (
            (known(PUBLIC, **rows), ""),
            (known(OWN, new="puma"), person),
            (known(STAFF, robot=1), staff),
        )
        for (code, locale), (size, (width, height)), (pages, session) in product(
            LANGUAGES.items(), SIZES.items(), groups
        ):
            viewport = {"width": width, "height": height}
            context = browsers[locale].new_context(base_url=url, locale=locale, viewport=viewport)
            if session:
                context.add_cookies([{"name": "sessionid", "value": session, "url": url}])
            page = context.new_page()
            for name, address in pages.items():
                if not only or name in only:
                    page.goto(address)
                    page.wait_for_timeout(400 if address.startswith("/accounts/") else 2500)
                    take(page, folder / code, f"{name}-{size}")
            context.close()
        for browser in browsers.values():
            browser.close()


def started(playwright, locale: str):
    """Return a browser whose own parts of a page, as fields for dates, are in that language, too."""
    env = {**os.environ, "LANGUAGE": locale.replace("-", "_")}
    arguments = ["--no-sandbox", f"--lang={locale}"]
    return playwright.chromium.launch(executable_path=os.environ["FARHAND_CHROMIUM"], args=arguments, env=env)


def take(page, folder: Path, name: str) -> None:
    """Write a page's pictures in both colour schemes: the whole page, or of one with a stage what is in view."""
    folder.mkdir(parents=True, exist_ok=True)
    for scheme in SCHEMES:
        page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        page.wait_for_timeout(200)
        size = page.viewport_size
        whole = page.evaluate("document.getElementById('stage') ? 0 : document.documentElement.scrollHeight")
        clip = {"x": 0, "y": 0, "width": size["width"], "height": min(max(whole, size["height"]), LONGEST_PX)}
        shot = page.screenshot(full_page=True, clip=clip)
        Image.open(io.BytesIO(shot)).convert("RGB").save(folder / f"{name}-{scheme}.webp", **WEBP)


def driven(page) -> dict[str, str]:
    """Drive Mercury for some commands, leave, write in the log, and ask the iRat for something; return what that made."""
    page.goto("/robots/mercury/")
    for _ in range(60):  # the robots start, on a busy machine for minutes
        button = page.locator("#place :is([data-do=take], [data-do=join], [data-do=accept])").first
        if button.count() and button.get_attribute("aria-disabled") != "true":
            button.click()
        page.wait_for_timeout(3000)
        if page.locator(".operating").count():
            break
    for name in ("down", "air", "air", "up"):
        page.locator(f"[data-command={name}][aria-disabled=false]").first.click(timeout=60_000)
        page.wait_for_timeout(2500)
    for _ in range(2):  # the first press asks
        page.locator("#place [data-do=leave]").press("Enter")
        page.wait_for_timeout(500)
    link = page.locator("a[href^='/turns/']").first
    link.wait_for(timeout=60_000)
    address = link.get_attribute("href")
    page.goto(address)
    page.fill("textarea[name=text]", "Four bursts in the corner, and there it was: a small round thing with a lid.")
    page.locator("main form.form button").first.click()
    page.wait_for_timeout(1000)
    recording = page.locator("main a[href^='/recordings/']").first.get_attribute("href")
    page.goto("/robots/irat/jobs/")
    page.locator("main form.form button").first.click()
    page.wait_for_url("**/jobs/*/")
    names = {"turn": address, "recording": recording.partition("?")[0], "job": page.url}
    return {name: found.rstrip("/").rpartition("/")[2] for name, found in names.items()}


@contextmanager
def demo() -> Iterator[tuple[str, ...]]:
    """Give the address of a demo, the sessions of a person and of staff, and the keys of two links in mails."""
    with tempfile.TemporaryDirectory() as var:
        env = {**os.environ, "FARHAND_VAR": var, "PYTHONPATH": "."}
        child = subprocess.Popen(
            [sys.executable, "manage.py", "demo", "--port", str(PORT)], env=env, stdout=subprocess.PIPE, text=True
        )
        try:
            assert child.stdout is not None
            for line in child.stdout:
                if "ready in" in line:
                    break
            made = subprocess.run(
                [sys.executable, "manage.py", "shell", "-c", PEOPLE],
                env=env,
                check=True,
                capture_output=True,
                text=True,
            ).stdout
            sessions = made.partition("people ")[2].split()
            yield (f"http://localhost:{PORT}", *(one.partition("=")[2] for one in sessions))
        finally:
            child.send_signal(signal.SIGTERM)
            child.wait(60)


if __name__ == "__main__":
    main()
