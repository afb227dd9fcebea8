"""The choice of the language, and the texts of the page's scripts."""

import hashlib
from functools import cache

from django.conf import settings
from django.http import Http404, HttpRequest, HttpResponse
from django.utils import translation
from django.views.decorators.csrf import csrf_exempt
from django.views.decorators.http import require_GET, require_POST
from django.views.i18n import JavaScriptCatalog, set_language

from accounts.services import keep_language
from portal.edge.cache_control import FOR_GOOD
from robots.sentences import DOMAIN

OWN = b"\nglobalThis.texts = globalThis.django;\n"  # the admin's own script replaces `django`


@csrf_exempt  # no more than the language of pages changes; a token would set a cookie on pages that need none
@require_POST
def choose(request: HttpRequest) -> HttpResponse:
    """Set the language of the pages, and of mails to a person who is signed in; lead back to the page."""
    answer = set_language(request)
    language = request.POST.get("language", "")
    if request.user.is_authenticated and language in dict(settings.LANGUAGES):
        keep_language(request.user, language)
    return answer


@require_GET
def texts(request: HttpRequest, language: str, version: str) -> HttpResponse:
    """Return a script with the texts of a language. `version`: a digest of them."""
    if language not in dict(settings.LANGUAGES):
        raise Http404
    newest = version_of(language)
    headers = {"Cache-Control": FOR_GOOD if version == newest else "no-store"}
    return HttpResponse(_script(language), content_type="text/javascript; charset=utf-8", headers=headers)


@cache
def version_of(language: str) -> str:
    """Return a digest of the texts of a language."""
    return hashlib.sha256(_script(language)).hexdigest()[:16]


@cache
def _script(language: str) -> bytes:
    view = JavaScriptCatalog(domain=DOMAIN, packages=["portal"])
    with translation.override(language):
        return bytes(view.get(HttpRequest()).content) + OWN
