"""How allauth fits in here."""

from allauth.account.adapter import DefaultAccountAdapter


class AccountAdapter(DefaultAccountAdapter):  # type: ignore[misc]
    """Everything is allauth's own; the client's address counts trusted proxies (settings)."""

    username_blacklist_case_insensitive = True
