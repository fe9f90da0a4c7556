"""Links of README, manual and demos: each leads to a file, and to a heading where it names one."""

import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.serial
ROOT = Path(__file__).parents[2]
PAGES = [
    *ROOT.glob("*.md"),
    *sorted(path for folder in ("docs", "demos") for path in (ROOT / folder).rglob("*.md")),
]
CODE = re.compile(r"^```.*?^```|`[^`\n]*`", re.M | re.S)
LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\]]*\])*\]\((?P<target>[^()\s]+)\)")
HEADING = re.compile(r"^#+ (?P<text>.+)$", re.M)
ELSEWHERE = ("http://", "https://", "mailto:")


def anchors(page):
    """Anchors of a page's headings, as a git server and MyST make them."""
    text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.M | re.S)
    for heading in HEADING.finditer(text):
        words = re.sub(r"[^\w\- ]", "", heading["text"].strip().lower())
        yield words.replace(" ", "-")


def links():
    for page in PAGES:
        for found in LINK.finditer(CODE.sub("code", page.read_text("utf-8"))):
            if not found["target"].startswith(ELSEWHERE):
                yield pytest.param(page, found["target"], id=f"{page.name} {found['target']}")


@pytest.mark.parametrize(("page", "target"), links())
def test_link_leads_somewhere(page, target):
    path, _, anchor = target.partition("#")
    file = page.parent / path if path else page
    assert file.exists(), target
    assert not anchor or anchor in anchors(file), f"{target}: no such heading"


def test_every_page_of_the_manual_is_in_its_table_of_contents():
    index = (ROOT / "docs" / "index.md").read_text("utf-8")
    for page in (ROOT / "docs").glob("*.md"):
        assert page.stem == "index" or f"\n{page.stem}\n" in index, page.name


def test_readme_is_one_page():
    assert len((ROOT / "README.md").read_bytes()) <= 7000
