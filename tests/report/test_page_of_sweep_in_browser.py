"""The interactive page of a sweep, as a reader uses it: in a browser."""

import pytest
from browsing import errors, requests, wait_for
from sweep_examples import content_of, sweep_of

from boltjoint.report.pages.sweep.page import sweep_page
from boltjoint.study.tables.sobol_indices import tabulate_sensitivity

pytestmark = pytest.mark.report

#: the plotted data of a drawing
DATA = "return document.getElementById(arguments[0]).data"


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    content = content_of("saltelli", 64)
    page = sweep_page("swept", sweep_of("saltelli"), content, tabulate_sensitivity(content))
    path = tmp_path_factory.mktemp("sweep") / "explore.html"
    path.write_text(page, encoding="utf-8")
    return path.as_uri()


@pytest.fixture
def page(browser, address):
    """The page, as it is opened; all that it loads or complains of is a failure."""
    errors(browser), requests(browser)
    browser.get(address)
    wait_for(browser, lambda: browser.execute_script("return document.body.dataset.ready"))
    yield browser
    assert requests(browser) == [address]
    assert errors(browser) == []


def test_a_page_without_any_peak_opens(browser, tmp_path):
    content = content_of("latin-hypercube", 6, failed=6)
    for name in ("peak_frequency", "peak_amplitude", "response_amplitude"):
        content[name] *= float("nan")
    path = tmp_path / "explore.html"
    path.write_text(sweep_page("swept", sweep_of("latin-hypercube"), content), encoding="utf-8")
    errors(browser)
    browser.get(path.as_uri())
    wait_for(browser, lambda: browser.execute_script("return document.body.dataset.ready"))
    assert text(browser, "count") == "0 of 6 designs with a peak, 0 responses drawn"
    assert len(browser.find_elements("css selector", "#failures tbody tr")) == 2
    assert errors(browser) == []


def text(page, name):
    return page.find_element("id", name).text


def drawn(page):
    """Number of responses that are drawn, by what stands above and by the lines themselves."""
    told = int(text(page, "count").split(", ")[1].split()[0])
    lines = page.execute_script(
        "return document.getElementById('responses').data"
        ".filter(each => each.customdata).flatMap(each => each.customdata)"
    )
    assert len(set(lines)) == told
    return set(lines)


def press(page, start, end=None):
    """Press the mouse at a place of the window, and release it there or at another one."""
    from selenium.webdriver.common.action_chains import ActionChains

    actions = ActionChains(page, duration=50)
    pointer = actions.w3c_actions.pointer_action
    pointer.move_to_location(*map(round, start))
    pointer.pointer_down()
    if end is not None:
        for share in (0.3, 0.6, 1):
            place = [a + share * (b - a) for a, b in zip(start, end, strict=True)]
            pointer.move_to_location(*map(round, place))
    pointer.pointer_up()
    actions.perform()


def box(page, selector, number=0):
    """Left and upper end, width and height of an element in the window, once it is in view."""
    return page.execute_script(
        "const found = document.querySelectorAll(arguments[0])[arguments[1]];"
        "found.scrollIntoView({block: 'center', behavior: 'instant'});"
        "const box = found.getBoundingClientRect();"
        "return [box.left, box.top, box.width, box.height]",
        *(selector, number),
    )


def click(page, selector):
    """Press the middle of an element: the page scrolls smoothly, which a click would not await."""
    left, top, width, height = box(page, selector)
    press(page, (left + width / 2, top + height / 2))


def test_a_brush_chooses_the_responses_that_are_drawn(page):
    before = drawn(page)
    assert len(before) == 128
    left, top, width, height = box(page, "#parallel .axis-brush .background", 0)
    middle = left + width / 2
    press(page, (middle, top + 0.4 * height), (middle, top + 0.7 * height))
    wait_for(page, lambda: "within the limits" in text(page, "count"))
    after = drawn(page)
    assert 10 < len(after) < 80 and after < before
    loads = page.execute_script("return [...axes[0].ofLevel(0)]")
    low, high = page.execute_script("return state.limits.get(0)[0]")
    # the preload goes from 8 kN to 12 kN; a brush at its ends is a few pixels off
    assert (low, high) == pytest.approx((9200, 10400), abs=150)
    assert after == {place for place in before if low <= loads[place] <= high}
    page.find_element("id", "clear").click()
    assert drawn(page) == before
    assert not page.find_element("id", "clear").is_enabled()


def test_limits_may_be_typed(page):
    click(page, "summary")
    lowest = page.find_element("css selector", '#limits input[data-axis="1"][data-end="low"]')
    lowest.send_keys("0.3\n")
    wait_for(page, lambda: "within the limits" in text(page, "count"))
    friction = page.execute_script("return [...axes[1].ofLevel(0)]")
    assert drawn(page) == {place for place, value in enumerate(friction) if value >= 0.3}
    ranges = page.execute_script(
        "return document.getElementById('parallel').data[0].dimensions[1].constraintrange"
    )
    assert len(ranges) in (1, 2)
    # means are of the same designs
    cells = page.execute_script(DATA, "heat-map")[0]["z"]
    assert sum(value is not None for row in cells for value in row) < 16


def test_the_slider_changes_the_level(page):
    from selenium.webdriver.common.keys import Keys

    def drawings():
        names = ("responses", "heat-map", "slices", "shares-of-frequency")
        return [page.execute_script(DATA, name) for name in names]

    slider = page.find_element("id", "level")
    assert text(page, "level-value") == "100 N"
    before = drawings()
    slider.send_keys(Keys.ARROW_LEFT)
    wait_for(page, lambda: text(page, "level-value") == "10 N")
    after = drawings()
    assert all(one != other for one, other in zip(before, after, strict=True))
    # the median response to a tenth of the force is smaller
    median = [
        next(each for each in one[0] if each.get("name") == "median of all designs")
        for one in (before, after)
    ]
    largest = [
        max(each["y"].values() if isinstance(each["y"], dict) else each["y"]) for each in median
    ]
    assert largest[1] < 0.5 * largest[0]


def test_the_heat_map_is_of_the_chosen_keys_and_peak(page):
    def titles():
        return page.execute_script(
            "const drawn = document.getElementById('heat-map');"
            "return [drawn.layout.xaxis.title.text, drawn.layout.yaxis.title.text,"
            " drawn.data[0].colorbar.title.text]"
        )

    assert titles() == ["preload (N)", "friction coefficient", "mean peak amplitude (mm)"]
    before = page.execute_script(DATA, "heat-map")[0]["z"]
    for name, words in (("second", "loss factor"), ("peak", "peak frequency (Hz)")):
        chosen = page.find_element("id", name)
        option = f".//option[normalize-space()='{words}']"
        chosen.find_element("xpath", option).click()
    assert titles() == ["preload (N)", "loss factor", "mean peak frequency (Hz)"]
    assert page.execute_script(DATA, "heat-map")[0]["z"] != before
    slices = page.execute_script("return document.getElementById('slices').layout")
    assert slices["yaxis"]["title"]["text"] == "peak frequency (Hz)"
    assert slices["legend"]["title"]["text"] == "loss factor"


def test_a_click_on_a_response_tells_its_design(page):
    box(page, "#responses .nsewdrag")
    at = page.execute_script(
        "const drawn = document.getElementById('responses'), point = 30;"
        "const line = drawn.data.find(each => each.customdata && each.x.length);"
        "const {xaxis, yaxis} = drawn._fullLayout;"
        "const box = drawn.getBoundingClientRect();"
        "return [box.left + xaxis._offset + xaxis.d2p(line.x[point]),"
        " box.top + yaxis._offset + yaxis.d2p(line.y[point])]"
    )
    press(page, at)
    wait_for(page, lambda: text(page, "design").startswith("Design "))
    told = text(page, "design")
    assert "preload" in told and "peak amplitude" in told
    number = int(told.removeprefix("Design ").split(":")[0])
    named = [each.get("name") for each in page.execute_script(DATA, "responses")]
    assert f"design {number}" in named
    assert f"design {number}" in [each.get("name") for each in page.execute_script(DATA, "slices")]


def test_bands_and_responses_may_be_hidden(page):
    click(page, "#bands")
    click(page, "#lines")
    assert not any(each["visible"] for each in page.execute_script(DATA, "responses"))


def test_all_drawings_have_room_and_axes_with_titles(page):
    found = page.execute_script(
        "return [...document.querySelectorAll('.plot')].map(each => {"
        " const box = each.getBoundingClientRect(), {xaxis, yaxis} = each._fullLayout;"
        " return [each.id, box.width, box.height, yaxis && yaxis.title.text]; })"
    )
    assert [each[0] for each in found] == [
        *("parallel", "responses", "heat-map", "slices"),
        *("shares-of-frequency", "shares-of-amplitude"),
    ]
    for name, width, height, title in found:
        assert width > 400 and height > 300, name
        assert name == "parallel" or title, name
    sides = page.execute_script(
        "return [document.documentElement.scrollWidth, document.documentElement.clientWidth]"
    )
    assert sides[0] <= sides[1]
