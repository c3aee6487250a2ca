"""The documentation works from a folder in a real browser: search, dark mode, pictures; no request leaves it."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (the extra 'dev')")
pytest.importorskip("material", reason="mkdocs-material is not installed (the extra 'docs')")

ROOT = Path(__file__).resolve().parents[2]
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
PATIENCE_MS = 60_000

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium on PATH")]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A small site with the configuration of the whole one: two pages, no reference."""
    folder = tmp_path_factory.mktemp("docs")
    shutil.copytree(ROOT / "docs" / "assets", folder / "docs" / "assets")
    shutil.copytree(ROOT / "docs" / "images", folder / "docs" / "images")
    (folder / "docs" / "index.md").write_text("# First\n\n![film](images/lift.webp)\n\n    a command\n")
    (folder / "docs" / "other.md").write_text("# Other\n\n## Gearbox\n\nA flywheel turns.\n")
    text = (ROOT / "mkdocs.yml").read_text()
    settings = text[text.index("theme:") : text.index("hooks:")] + text[text.index("markdown_extensions:") :]
    head = "site_name: Small\nsite_url: ''\nuse_directory_urls: false\nplugins: [search, offline]\n"
    (folder / "mkdocs.yml").write_text(head + settings)
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return (folder / "site").as_uri()


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as program:
        chromium = program.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"], timeout=PATIENCE_MS)
        yield chromium
        chromium.close()


@pytest.fixture(params=["light", "dark"])
def page(browser, request):
    """A page for a system with light or dark windows; fails on errors and on requests that leave the folder."""
    page = browser.new_page(color_scheme=request.param)
    page.set_default_timeout(PATIENCE_MS)
    wrong = []
    page.on("request", lambda sent: sent.url.startswith(("file:", "data:", "blob:")) or wrong.append(sent.url))
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.scheme = {"light": "default", "dark": "slate"}[request.param]
    yield page
    page.close()
    assert wrong == []


def test_search_colours_and_copying_work_from_a_folder(site, page):
    page.goto(f"{site}/index.html")
    assert page.get_attribute("body", "data-md-color-scheme") == page.scheme
    page.wait_for_function("document.querySelector('article img').naturalWidth > 0")
    assert page.locator(".md-code__button, .md-clipboard").count() == 1  # copies the command
    page.click("input[name=query]")
    page.type("input[name=query]", "flywheel")
    found = page.locator(".md-search-result__item a").first
    found.wait_for()
    assert "Gearbox" in page.locator(".md-search-result__item").first.inner_text()
    found.click()
    page.wait_for_url("**/other.html*")
    assert "A flywheel turns." in page.inner_text("article")
    page.locator("label.md-header__button[title*='mode']:visible").click()  # leaves the system's setting
    assert page.get_attribute("body", "data-md-color-scheme") == "default"
