"""The site of the documentation on a phone: `make docs` builds it, strictly."""

from pathlib import Path
from typing import Any

import pytest

from tests.pages import ROOT

pytestmark = pytest.mark.browser
SITE = ROOT / "out" / "site"
PHONE = {"width": 390, "height": 844}
# Elements that stand out of the window and do not lie in a box that scrolls, or is cut off.
TOO_WIDE = """
() => [...document.querySelectorAll("body *")].filter((each) => {
  const box = each.getBoundingClientRect();
  if (box.width === 0 || box.right <= innerWidth + 1) return false;
  for (let at = each.parentElement; at; at = at.parentElement)
    if (getComputedStyle(at).overflowX !== "visible") return false;
  return true;
}).map((each) => `${each.tagName} ${each.className}: ${each.textContent.trim().slice(0, 40)}`)
"""
CUT_OFF = """
() => [...document.querySelectorAll("article *")].filter((each) =>
  ["hidden", "clip"].includes(getComputedStyle(each).overflowX)
  && each.clientWidth > 0 && each.scrollWidth > each.clientWidth + 1
).map((each) => `${each.tagName} ${each.className}: ${each.textContent.trim().slice(0, 40)}`)
"""


def faults(page: Any, path: Path) -> list[str]:
    """What is wider than the window on a page, or cut off so that nobody can read it."""
    page.goto(path.as_uri())
    width = page.evaluate("document.documentElement.scrollWidth")
    wide = [f"the page: {width} pixels"] if width > PHONE["width"] else []
    return wide + page.evaluate(TOO_WIDE) + page.evaluate(CUT_OFF)


@pytest.fixture(scope="module")
def phone(chromium: Any) -> Any:
    """A tab as wide as a phone, without a network."""
    return chromium.new_context(offline=True, viewport=PHONE).new_page()


def test_no_page_is_wider_than_a_phone(phone: Any) -> None:
    pages = sorted(SITE.rglob("*.html"))
    if not pages:
        pytest.skip(f"{SITE} is not there: make docs builds it")
    found = {path.relative_to(SITE): faults(phone, path) for path in pages}
    assert {path: told for path, told in found.items() if told} == {}
    assert len(pages) > 30


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("<p style='width: 800px'>wide</p>", "P : wide"),
        ("<article><p style='overflow: hidden; white-space: nowrap'>" + "cut " * 99, "P : cut"),
    ],
)
def test_what_is_wide_is_found(phone: Any, tmp_path: Path, body: str, said: str) -> None:
    page = tmp_path / "page.html"
    page.write_text(f"<!doctype html><body>{body}")
    assert any(fault.startswith(said) for fault in faults(phone, page))


def test_a_table_in_a_box_that_scrolls_is_no_fault(phone: Any, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    row = "<tr>" + "<td>value</td>" * 50
    page.write_text(f"<!doctype html><article><div style='overflow: auto'><table>{row}")
    assert faults(phone, page) == []
