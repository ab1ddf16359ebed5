"""The report of a small study, as a reader has it: in a browser."""

import re
from urllib.parse import unquote

import pytest
from browsing import errors, wait_for
from small_study import CASES, SWEEPS, run

pytestmark = pytest.mark.report

PAGES = ("overview", "accuracy", "structure", *CASES)


@pytest.fixture(scope="module")
def report(finished, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "report.html"
    run(finished, "--report", str(path))
    return path


def named(browser, text, among="a"):
    """The link that says so, once it is there."""
    return wait_for(
        browser,
        lambda: next(
            (
                each
                for each in browser.find_elements("css selector", among)
                if each.text.strip() == text
            ),
            None,
        ),
    )


def page_in_frame(browser):
    """Heading, figures and tables of the page that the report shows."""
    frame = wait_for(browser, lambda: next(iter(browser.find_elements("tag name", "iframe")), None))
    browser.switch_to.frame(frame)
    wait_for(browser, lambda: browser.find_elements("tag name", "h1"))
    found = browser.execute_script(
        "return [document.querySelector('h1').textContent,"
        " document.querySelectorAll('figure svg').length,"
        " document.querySelectorAll('tbody tr').length]"
    )
    browser.switch_to.default_content()
    return found


def test_report_opens_on_the_answer(browser, report):
    browser.get(report.as_uri())
    title, _, rows = page_in_frame(browser)
    assert title == "Nonlinear vibration of bolted joints"
    assert rows > 0
    # and tells of its jobs when it is asked
    named(browser, "Workflow").click()
    wait_for(browser, lambda: "friction between the bars" in front(browser))
    assert errors(browser) == []


def front(browser):
    """The text of the report around its pages."""
    return browser.find_element("id", "app").text


def test_front_page_opens_every_page(browser, report):
    opened = []
    for name in ("Overview", "Accuracy", "Structure", *CASES):
        browser.get(report.as_uri())
        page_in_frame(browser)
        named(browser, "Workflow").click()
        named(browser, name, ".prose a").click()
        opened.append(page_in_frame(browser)[0])
    titles = ["Nonlinear vibration of bolted joints", "Accuracy", "Structure", *CASES]
    assert opened == titles
    assert errors(browser) == []


def test_every_item_of_the_report_opens(browser, report, finished):
    browser.get(report.as_uri())
    pages, tables = [], []
    categories = browser.execute_script("return categories")
    assert list(sorted(categories)) == [
        "1. Overview",
        "2. Structure",
        "3. Case studies",
        "4. Tables",
    ]
    for category, subcategories in categories.items():
        for subcategory, items in subcategories.items():
            browser.get(report.as_uri())
            named(browser, category).click()
            if len(subcategories) > 1:
                named(browser, subcategory).click()
            rows = wait_for(browser, lambda: browser.find_elements("css selector", "#app tbody tr"))
            assert len(rows) == len(items)
            for row in rows:
                eye = row.find_element("css selector", "a")
                if eye.get_attribute("download"):
                    assert eye.get_attribute("href").startswith("data:text/csv")
                    tables.append(eye.get_attribute("download"))
                else:
                    eye.click()
                    pages.append(page_in_frame(browser))
    written = (finished / "results/tables").glob("*.csv")
    assert sorted(tables) == sorted(path.name for path in written)
    assert len(pages) == len(PAGES)
    for name, figures, rows in pages:
        assert rows > 0, name
        assert figures > 0 or name.startswith("Nonlinear"), name
    assert errors(browser) == []


@pytest.mark.parametrize("name", PAGES)
def test_page_by_itself(browser, report, finished, name):
    page = finished / f"results/report/{name}.html"
    browser.get(page.as_uri())
    assert errors(browser) == []
    small = browser.execute_script(
        "document.querySelectorAll('details').forEach(each => { each.open = true; });"
        "return [...document.querySelectorAll('figure svg, figure img')].filter(each => {"
        " if (!each.checkVisibility()) return false;"
        " const box = each.getBoundingClientRect();"
        " return box.width < 300 || box.height < 50; }).length"
    )
    assert small == 0
    empty = browser.execute_script(
        "return [...document.querySelectorAll('table')].filter("
        "each => each.tBodies[0].rows.length == 0).length"
    )
    assert empty == 0
    width = browser.execute_script(
        "return [document.documentElement.scrollWidth, document.documentElement.clientWidth]"
    )
    assert width[0] <= width[1]


def test_links_of_pages_lead_somewhere(finished):
    folder = finished / "results/report"
    texts = {path.name: path.read_text() for path in folder.glob("*.html")}
    assert len(texts) == len(PAGES)
    for name, text in texts.items():
        assert not re.search(r'(?:src|href)="(?!data:)[a-z]+:', text), "something from elsewhere"
        for link in re.findall(r'<a [^>]*href="([^"]+)"', text):
            file, _, anchor = unquote(link).partition("#")
            assert not file or (folder / file).exists(), (name, link)
            if anchor:
                assert f' id="{anchor}"' in texts[file or name], (name, link)


def test_the_page_of_a_case_leads_to_those_of_its_sweeps_and_back(browser, report, finished):
    browser.get((finished / "results/report/small.html").as_uri())
    for name in SWEEPS:
        address = f'a[href="../sweeps/{name}/explore.html"]'
        opened = browser.find_element("css selector", address).get_attribute("href")
        browser.get(opened)
        wait_for(browser, lambda: browser.execute_script("return document.body.dataset.ready"))
        assert browser.find_element("tag name", "h1").text == name
        named(browser, "small").click()
        wait_for(browser, lambda: browser.current_url.endswith("report/small.html#sweeps"))
        assert browser.find_element("id", "sweeps").is_displayed()
    assert errors(browser) == []


def test_every_figure_and_table_is_on_a_page(finished):
    text = "".join(path.read_text() for path in (finished / "results/report").glob("*.html"))
    results = finished / "results"
    shown = [*(results / "figures").iterdir(), *(results / "tables").glob("*.csv")]
    for path in shown:
        assert f'href="../{path.parent.name}/{path.name}"' in text, path.name


def test_pages_in_the_report_have_no_links_that_lead_nowhere(browser, report, finished):
    for name in PAGES:
        browser.get((finished / f"results/report/packed/{name}.html").as_uri())
        wait_for(browser, lambda: browser.find_elements("tag name", "h1"))
        links = browser.execute_script(
            "return [...document.querySelectorAll('a')].map(each => each.getAttribute('href'))"
        )
        assert links
        assert all(link.startswith("#") for link in links)
