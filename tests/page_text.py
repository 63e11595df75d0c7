"""What stands in a report's page: its tags, its text, the data packed into it."""

from __future__ import annotations

import base64
import gzip
import re
from html.parser import HTMLParser


class Tags(HTMLParser):
    """Collects the tags, their attributes and the text outside of scripts and styles."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.said: list[str] = []
        self.quiet = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self.quiet = tag in {"script", "style"}

    def handle_endtag(self, tag: str) -> None:
        self.quiet = False

    def handle_data(self, data: str) -> None:
        if not self.quiet:
            self.said.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.said).replace("\u00a0", " ").split())


def packed(page: str, name: str) -> str:
    found = re.search(rf'id="packed-{name}">([^<]*)<', page)
    assert found
    return gzip.decompress(base64.b64decode(found[1])).decode()
