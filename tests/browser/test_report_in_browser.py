"""The report's page in a real browser: wide and narrow windows, light and dark, contents that lead somewhere."""

import shutil

import numpy as np
import pytest

from lift_lab_rl.study.comparison import Roles
from lift_lab_rl.study.curves import Group, TrainingRun
from lift_lab_rl.study.page import write_report
from lift_lab_tasks.manager_based.manipulation.lift.paper import PAPER

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (the extra 'dev')")

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
PATIENCE_MS = 60_000
WIDE, NARROW = (1400, 900), (390, 844)

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium on PATH")]


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """The page of a baseline and a curriculum with every figure."""
    steps, values = np.array([1, 2, 3]), np.array([0.1, 0.2, 0.3])
    scalars = {figure.tags[0]: (steps, values) for figure in (*PAPER.figures, *PAPER.further)}
    labels = (PAPER.baseline_task, PAPER.curriculum_task)
    groups = [Group(label, [TrainingRun(label, 1, [], scalars)]) for label in labels]
    roles = Roles(*labels)
    notes = ["the runs of 'x' have no " + "Episode_Reward/a_very_long_name_of_a_term" * 3]
    return write_report(groups, {}, PAPER, roles, tmp_path_factory.mktemp("report"), notes=notes).as_uri()


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as program:
        chromium = program.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"], timeout=PATIENCE_MS)
        yield chromium
        chromium.close()


@pytest.mark.parametrize("size", [WIDE, NARROW], ids=["wide", "narrow"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_fits_its_window_and_leads_to_its_parts(browser, address, size, scheme):
    page = browser.new_page(color_scheme=scheme, viewport={"width": size[0], "height": size[1]})
    page.set_default_timeout(PATIENCE_MS)
    asked, errors = [], []
    page.on("request", lambda request: request.url.startswith("data:") or asked.append(request.url))
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(address)
    assert page.evaluate("document.documentElement.scrollWidth") == size[0]

    background = page.evaluate("getComputedStyle(document.body).backgroundColor").strip("rgb()").split(", ")
    assert (sum(map(int, background)) / 3 < 60) == (scheme == "dark")
    picture = page.locator("figure img").first
    assert ("invert" in picture.evaluate("image => getComputedStyle(image).filter")) == (scheme == "dark")
    assert picture.evaluate("image => image.naturalWidth") > 500

    contents = page.locator("nav")
    assert contents.bounding_box()["width"] < 300 if size == WIDE else contents.bounding_box()["width"] > 300
    figure = page.locator("nav a", has_text="Fig. 21.")
    assert figure.is_visible() == (size == WIDE)
    headings = page.locator("h2").all_inner_texts()
    assert headings[0] == "Success"
    for link in page.locator("nav > details > ul > li > a").all()[:: len(headings) - 1]:  # the first and the last
        link.click()
        heading = page.locator("h2", has_text=link.inner_text())
        assert heading.evaluate(
            "h => h.getBoundingClientRect().top < innerHeight && h.getBoundingClientRect().top >= 0"
        )
    assert errors == []
    assert asked == [address]
    page.close()
