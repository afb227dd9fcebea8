"""How long browsers and caches keep an answer."""

FOR_GOOD = "public, max-age=31536000, immutable"  # the address names the content, which never changes
