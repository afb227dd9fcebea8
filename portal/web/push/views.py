"""The push subscriptions of a person, one for each browser, and the service worker that shows the messages."""

from functools import cache

from django.conf import settings
from django.contrib import messages
from django.contrib.auth.decorators import login_required
from django.http import Http404, HttpRequest, HttpResponse, JsonResponse
from django.middleware.csrf import get_token
from django.shortcuts import redirect
from django.utils.translation import gettext
from django.views.decorators.cache import never_cache
from django.views.decorators.http import require_GET, require_http_methods

from accounts.push import SESSION, PushRefused, subscribe, subscriptions_of, unsubscribe
from portal.edge.attempts import within
from portal.folders import FRONTEND_DIST
from portal.web.push.messages import checked_endpoint, checked_keys, public_key
from robots.kit.clock import SYSTEM
from robots.kit.plain import whole

# the first that the browser names: most name others, too
BROWSERS = {
    "Edg": "Edge", "OPR/": "Opera", "SamsungBrowser": "Samsung Internet", "Firefox": "Firefox", "Chrom": "Chrome",
    "Safari": "Safari",
}  # fmt: skip
SYSTEMS = {
    "Android": "Android", "iPhone": "iPhone", "iPad": "iPad", "Windows": "Windows", "Mac OS": "macOS",
    "CrOS": "ChromeOS", "Linux": "Linux",
}  # fmt: skip


def subscription_number(request: HttpRequest) -> int:
    """Return the number of the subscription of the browser of a request; 0 if the portal does not tell it."""
    number = request.session.get(SESSION)
    return number if isinstance(number, int) and subscriptions_of(request.user).filter(pk=number).exists() else 0


@never_cache
@require_http_methods(["GET", "POST"])
@login_required
def push(request: HttpRequest) -> HttpResponse:
    """Return what a script needs to add this browser (GET), or add or remove one (POST, `do`).

    `tell`: this browser from now on; `renew`: this browser, which is told already, at its new address; `stop`: this
    browser no more; `remove`: any browser of the person, by its `number`, no more.
    """
    if request.method != "POST":
        found = {"key": public_key(), "token": get_token(request), "told": subscription_number(request) > 0}
        return JsonResponse(found)
    if not within(request, "push"):
        return _answer(request, gettext("Too many changes within a minute. Try again in a minute."), 429)
    wanted = request.POST.get("do", "")
    try:
        if wanted == "tell" or (wanted == "renew" and subscription_number(request)):
            _tell(request)
            return _answer(request, "")
        if wanted == "stop":
            unsubscribe(request.user, request.session.pop(SESSION, None) or 0)
            return _answer(request, "")
        if wanted == "remove":
            gone = unsubscribe(request.user, whole(request.POST.get("number", "")) or 0)
            said = gettext("That browser is told no more.") if gone else gettext("That browser was removed before.")
            return _answer(request, "", said=said)
    except PushRefused as error:
        return _answer(request, str(error), 400)
    return _answer(request, gettext("That request is unknown; reload the page."), 400)


def _tell(request: HttpRequest) -> None:
    """Store this browser. Raises PushRefused."""
    if not settings.PUSH["ON"]:
        raise PushRefused(gettext("This portal sends no notifications to browsers."))
    form = request.POST
    endpoint = checked_endpoint(form.get("endpoint", ""))
    keys = checked_keys(form.get("p256dh", ""), form.get("auth", ""))
    before = subscription_number(request)
    agent = request.headers.get("User-Agent", "")[:400]
    one = subscribe(request.user, endpoint, keys, browser_of(agent), SYSTEM.now())
    if before and before != one.pk:
        unsubscribe(request.user, before)  # the same browser at its earlier address
    request.session[SESSION] = one.pk


def browser_of(agent: str) -> str:
    """Return the name of a browser and its system, as the person knows them; empty if they are not known."""
    names = (next((name for mark, name in table.items() if mark in agent), "") for table in (BROWSERS, SYSTEMS))
    return ", ".join(name for name in names if name)


def _answer(request: HttpRequest, wrong: str, status: int = 200, said: str = "") -> HttpResponse:
    """Answer a script; lead a form back to the person's page."""
    if not request.accepts("text/html"):
        return JsonResponse({"ok": not wrong, "text": wrong or said}, status=status)
    if wrong:
        messages.warning(request, wrong)
    elif said:
        messages.success(request, said)
    return redirect("me")


@require_GET
def worker(request: HttpRequest) -> HttpResponse:
    """Return the script of the service worker; at this address it may act for every page of the portal."""
    return HttpResponse(_script(), content_type="text/javascript; charset=utf-8", headers={"Cache-Control": "no-cache"})


@cache
def _script() -> bytes:
    try:
        return (FRONTEND_DIST / "push-worker.js").read_bytes()
    except OSError as error:
        raise Http404("The front end was not built.") from error
