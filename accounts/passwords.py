"""Refuses passwords made of the portal's own words; a new password ends what the old one began."""

import re
from typing import Any

from django.core.exceptions import ValidationError
from django.utils.translation import gettext

WORDS = ("farhand", "mercury", "museum", "robots", "robot", "password", "passwort", "operator", "admin", "arm")
LEFT = 8  # letters and digits that must remain without the words


class OwnWordsValidator:
    """Refuses a password that is mostly words about this portal."""

    def validate(self, password: str, user: Any = None) -> None:
        """Check that enough characters remain without those words. Raises ValidationError."""
        left = password.casefold()
        found = [word for word in WORDS if word in left]
        for word in found:
            left = left.replace(word, "")
        if found and len(re.sub(r"[\W_]", "", left)) < LEFT:
            said = gettext("This password is mostly “{word}”, which is easy to guess here; add other words.")
            raise ValidationError(said.format(word=found[0]), code="password_own_words")

    def password_changed(self, password: str, user: Any = None) -> None:
        """Tell no browser of the person any more: their other sessions end with the old password."""
        from accounts.push import unsubscribe_all  # noqa: PLC0415 - the settings name this module before the models

        if user is not None and user.pk:
            unsubscribe_all(user)

    def get_help_text(self) -> str:
        """Return the rule for the form."""
        return gettext("Your password can't be made mostly of words like “farhand”, “robot” or “admin”.")
