"""Reads pages in the pseudo-language, in which every word that is marked for translation is turned."""

import re
from html.parser import HTMLParser

PSEUDO = "ar-xb"
TURNED = re.compile("\u202e[^\u202c]*\u202c")
WORD = re.compile(r"[A-Za-z]{2,}")
SEEN = ("title", "alt", "aria-label", "placeholder")


class Texts(HTMLParser):
    """Collects what people read of a page."""

    def __init__(self, page):
        super().__init__()
        self.found, self._hidden = [], 0
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self._hidden += tag in ("script", "style")
        self.found += [value or "" for name, value in attrs if name in SEEN]
        named = dict(attrs)
        if named.get("name") == "description":
            self.found.append(named["content"])

    def handle_endtag(self, tag):
        self._hidden -= tag in ("script", "style")

    def handle_data(self, text):
        if not self._hidden:
            self.found.append(text)
