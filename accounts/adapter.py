"""Adapts allauth: handles, the count of failed attempts, links that a demo shows, and mails in the background."""

import logging
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import Any
from urllib.parse import urlsplit

from allauth.account.adapter import DefaultAccountAdapter
from allauth.core.internal.ratelimit import get_ip
from django.conf import settings
from django.contrib.auth import get_user_model
from django.core.mail import EmailMessage
from django.db.models import Q
from django.http import HttpRequest
from django.utils.translation import get_language, override

from accounts import handles

log = logging.getLogger(__name__)
# in the background, because the time to send a mail would show whether an address is known
_sender = ThreadPoolExecutor(1, "mail")
CONSOLE = "django.core.mail.backends.console.EmailBackend"
LINK = "confirmation_link"


def mails_go_to_terminal() -> bool:
    """Return whether mails go only to the terminal, as in a demo, where people who sign up cannot read them."""
    return settings.EMAIL_BACKEND == CONSOLE and not settings.PUBLIC


def _send(message: EmailMessage) -> None:
    try:
        message.send()
    except Exception:  # a mail server may fail in any way; the page has already announced the mail
        log.exception("a mail could not be sent")


def send_in_background(message: EmailMessage) -> None:
    """Send a mail in the background; a failure is written to the log."""
    if settings.MAIL_IN_BACKGROUND:
        _sender.submit(_send, message)
    else:
        message.send()


def on_site(address: str) -> str:
    """Return the address at the configured site: a link in a mail never follows the Host header of a request."""
    parts = urlsplit(address)
    return f"{settings.SITE_ADDRESS}{parts.path}{'?' if parts.query else ''}{parts.query}"


def _language_of(email: str, user: Any) -> str | None:
    """Return the language of mails to an address: its account's, else that of the page on which somebody typed it."""
    named = get_user_model().objects.filter(email__iexact=email).values_list("language", flat=True).first()
    chosen = named if named is not None or user is None else user.language
    return get_language() if chosen is None else chosen or settings.LANGUAGE_CODE


class AccountAdapter(DefaultAccountAdapter):  # type: ignore[misc]
    """The portal's adapter of allauth."""

    username_blacklist_case_insensitive = True

    def clean_username(self, username: str, shallow: bool = False) -> str:
        """Return a new handle in its stored form. Raises ValidationError if it is refused or taken."""
        handle = handles.normal(username)
        if not shallow and handles.is_taken(handle):
            raise self.validation_error("username_taken")
        return str(super().clean_username(handle, shallow))

    def _get_login_attempts_cache_key(self, request: HttpRequest, **credentials: Any) -> str:
        """Return the key of failed attempts: the account together with the network address.

        So nobody locks another person out. An account's handle and mail address share one count.
        """
        name = str(credentials.get("email") or credentials.get("username") or "").strip().lower()[:254]
        people = get_user_model().objects.filter(Q(username__iexact=name) | Q(email__iexact=name))
        known = people.values_list("pk", flat=True).first() if name else None
        return f"{get_ip(request)} {known or name}"

    def is_open_for_signup(self, request: HttpRequest) -> bool:
        """Return whether people may sign up. A demo's session begins here, so a double press shows the link too."""
        if mails_go_to_terminal():
            request.session.setdefault(LINK, "")
        return bool(super().is_open_for_signup(request))

    def save_user(self, request: HttpRequest, user: Any, form: Any, commit: bool = True) -> Any:
        """Store a new person with the language of the page, for later mails."""
        user.language = get_language() or ""
        return super().save_user(request, user, form, commit)

    def get_email_confirmation_url(self, request: HttpRequest, emailconfirmation: Any) -> str:
        """Return the link of a mail, which leads on to the page that the person wanted, in any browser."""
        from accounts.confirm import with_wanted  # noqa: PLC0415 - allauth's views need the adapter

        link = str(super().get_email_confirmation_url(request, emailconfirmation))
        return with_wanted(request, link, emailconfirmation.email_address.user)

    def send_confirmation_mail(self, request: HttpRequest, emailconfirmation: Any, signup: bool) -> None:
        """Send the link; a demo also shows it on the next page of this session."""
        super().send_confirmation_mail(request, emailconfirmation, signup)
        if mails_go_to_terminal():
            request.session[LINK] = self.get_email_confirmation_url(request, emailconfirmation)

    def send_account_already_exists_mail(self, email: str) -> None:
        """Send the mail, which has no link, and remove the link of an earlier sign-up from the session."""
        super().send_account_already_exists_mail(email)
        self.request.session.pop(LINK, None)

    def confirm_email(self, request: HttpRequest, email_address: Any) -> bool:
        """Confirm the address, and remove its link."""
        request.session.pop(LINK, None)
        return bool(super().confirm_email(request, email_address))

    def send_mail(self, template_prefix: str, email: str, context: dict[str, Any]) -> None:
        """Render a mail now, in the language of the person whose address it is, and send it in the background."""
        with override(_language_of(email, context.get("user"))):
            message = self.render_mail(template_prefix, email, self._filled(email, context))
        send_in_background(message)

    def _filled(self, email: str, given: dict[str, Any]) -> dict[str, Any]:
        from allauth.core import context  # noqa: PLC0415 - holds the request of this thread

        site = SimpleNamespace(name=settings.SITE_NAME, domain=urlsplit(settings.SITE_ADDRESS).netloc)
        links = {name: on_site(str(value)) for name, value in given.items() if name.endswith("_url")}
        return {
            "request": context.request, "email": email, "site_address": on_site("/"), **given, **links,
            "current_site": site,
        }  # fmt: skip
