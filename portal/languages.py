"""The languages of the portal. `tools/translations.py` makes the catalogues, `locale/<language>/LC_MESSAGES/*.po`.

The package of a robot may have such a folder, too.
"""

import os
from pathlib import Path

from robots.kit import installed

__all__ = [
    "LANGUAGES", "LANGUAGE_CODE", "LANGUAGE_COOKIE_AGE", "LANGUAGE_COOKIE_SAMESITE", "LOCALE_PATHS", "TIME_ZONE",
]  # fmt: skip
LANGUAGE_CODE, TIME_ZONE = "en", "UTC"
LANGUAGE_COOKIE_AGE, LANGUAGE_COOKIE_SAMESITE = 31536000, "Lax"  # s
LOCALE_PATHS = [Path(__file__).resolve().parent / "locale", *installed.catalogues()]
LANGUAGES = [("en", "English"), ("de", "Deutsch")]
# Right to left, made of the English texts: shows what is not translated, and what breaks where text is longer.
PSEUDO = ("ar-xb", "Pseudo")
if os.environ.get("FARHAND_PSEUDO"):
    LANGUAGES.append(PSEUDO)
