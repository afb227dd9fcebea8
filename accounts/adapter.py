"""How allauth fits in here: what attempts are counted by, and mail that nobody waits for."""

import logging
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from allauth.account.adapter import DefaultAccountAdapter
from allauth.core.internal.ratelimit import get_ip
from django.conf import settings
from django.contrib.auth import get_user_model
from django.core.mail import EmailMessage
from django.db.models import Q
from django.http import HttpRequest

log = logging.getLogger(__name__)
# one sender a process: how long a mail server takes must tell nobody whether an address is known
_sender = ThreadPoolExecutor(1, "mail")


def _send(message: EmailMessage) -> None:
    try:
        message.send()
    except Exception:  # a mail server may fail in any way; the page said already that a mail is on its way
        log.exception("a mail could not be sent")


class AccountAdapter(DefaultAccountAdapter):  # type: ignore[misc]
    """Everything else is allauth's own."""

    username_blacklist_case_insensitive = True

    def _get_login_attempts_cache_key(self, request: HttpRequest, **credentials: Any) -> str:
        """Return what failed attempts are counted by: the account and the network address together.

        So nobody locks another person out, and both names of an account share one count.
        """
        name = str(credentials.get("email") or credentials.get("username") or "").strip().lower()[:254]
        people = get_user_model().objects.filter(Q(username__iexact=name) | Q(email__iexact=name))
        known = people.values_list("pk", flat=True).first() if name else None
        return f"{get_ip(request)} {known or name}"

    def send_mail(self, template_prefix: str, email: str, context: dict[str, Any]) -> None:
        """Render a mail now, send it beside the answer."""
        message = self.render_mail(template_prefix, email, self._filled(email, context))
        if settings.MAIL_IN_BACKGROUND:
            _sender.submit(_send, message)
        else:
            message.send()

    def _filled(self, email: str, given: dict[str, Any]) -> dict[str, Any]:
        from allauth.core import context  # noqa: PLC0415 - holds the request of this thread
        from django.contrib.sites.shortcuts import get_current_site  # noqa: PLC0415

        request = context.request
        return {"request": request, "email": email, "current_site": get_current_site(request), **given}
