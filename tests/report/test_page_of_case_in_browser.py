"""The page of a case, as a reader uses it: in a browser."""

import csv
import re
import time

import pytest
from browsing import errors, requests, wait_for
from small_study import RESPONSES

pytestmark = pytest.mark.report

READY = "return document.body.dataset.ready"
DATA = "return document.getElementById(arguments[0]).data"


@pytest.fixture(scope="module")
def address(finished):
    return (finished / "results/report/small.html").as_uri()


@pytest.fixture
def page(browser, address):
    """The page, as it is opened; all that it loads or complains of is a failure."""
    errors(browser), requests(browser)
    browser.get(address)
    wait_for(browser, lambda: browser.execute_script(READY))
    yield browser
    assert requests(browser) == [address]
    assert errors(browser) == []


def mouse(page, at, press=False):
    """Move the mouse to a place of the window, and press it there."""
    from selenium.webdriver.common.action_chains import ActionChains

    actions = ActionChains(page, duration=20)
    pointer = actions.w3c_actions.pointer_action
    pointer.move_to_location(*map(round, at))
    if press:
        pointer.pointer_down()
        # as long as a finger does: what draws must see the button while it is down
        pointer.pause(0.3)
        pointer.pointer_up()
    actions.perform()


def click(page, element):
    """Click an element, wherever it is on the page."""
    page.execute_script("arguments[0].click()", element)


def choose(page, name, value):
    """Choose an option of a list."""
    page.execute_script(
        "const list = document.getElementById(arguments[0]); list.value = arguments[1];"
        "for (const name of ['input', 'change']) list.dispatchEvent(new Event(name))",
        *(name, value),
    )


def place_of_point(page, trace, point):
    """The place of a point of a response in the window, once it is in view."""
    return page.execute_script(
        "const drawn = document.getElementById('response-plot');"
        "drawn.scrollIntoView({block: 'center', behavior: 'instant'});"
        "const {x, y} = drawn.data[arguments[0]], {xaxis, yaxis} = drawn._fullLayout;"
        "const box = drawn.getBoundingClientRect();"
        "return [box.left + xaxis._offset + xaxis.d2p(x[arguments[1]]),"
        " box.top + yaxis._offset + yaxis.d2p(y[arguments[1]])]",
        *(trace, point),
    )


def curves(page):
    """The responses that are drawn, by their level and model."""
    drawn = page.execute_script(
        "return document.getElementById('response-plot').data.map((each, place) =>"
        " [each.meta, each.y ? Array.from(each.y) : [], place])"
    )
    return {(meta["level"], meta["model"]): (y, place) for meta, y, place in drawn if meta}


def test_the_pointer_reads_a_response(page):
    (level, model), (amplitude, place) = next(iter(curves(page).items()))
    assert (level, model) == (0.01, "node-to-node, linear modes (enriched-8)")
    peak = amplitude.index(max(amplitude))
    mouse(page, place_of_point(page, place, peak))
    read = wait_for(page, lambda: page.find_elements("css selector", "#response-plot .hovertext"))
    text = read[0].text
    assert "0.01 N" in text and "node-to-node" in text
    assert re.search(r"\d+\.\d\d Hz", text) and "mm/N" in text
    # no amplitude without its error
    assert "%" in text or "not tested" in text


def test_forces_and_models_are_switched_on_and_off(page):
    forces = page.find_elements("css selector", "#levels input")
    before = curves(page)
    assert sorted(level for level, _ in before) == [0.01, 20]
    click(page, forces[1])
    wait_for(page, lambda: len(curves(page)) == 1)
    assert [level for level, _ in curves(page)] == [0.01]
    click(page, forces[1])
    page.execute_script("document.querySelector('#explore details').open = true")
    models = page.find_elements("css selector", "#models input")
    assert len(models) == RESPONSES["small"]
    click(page, models[-1])
    wait_for(page, lambda: len(curves(page)) == 4)
    count = page.find_element("id", "models-count")
    assert count.text == f"2 of {len(models)} drawn"
    choose(page, "over", "displacement")
    scaled = curves(page)
    for key in before:
        assert max(scaled[key][0]) == pytest.approx(max(before[key][0]) * key[0], rel=1e-6)


def test_curves_are_downloaded_as_rows(page):
    text = page.execute_script("return curvesAsCsv()")
    rows = list(csv.DictReader(text.splitlines()))
    drawn = curves(page)
    assert len(rows) == sum(len(y) for y, _ in drawn.values())
    largest = max(float(row["response_mm/N"]) for row in rows if row["level_N"] == "0.01")
    assert largest == pytest.approx(max(next(iter(drawn.values()))[0]), rel=1e-6)
    assert {row["basis"] for row in rows} == {"enriched-8"}
    assert {row["harmonics"] for row in rows} == {"one harmonic"}


def test_backbones_are_read_over_amplitude(page):
    drawn = page.execute_script(DATA, "backbone-plot")
    quantities = [each["meta"]["quantity"] for each in drawn if "meta" in each]
    assert quantities == ["frequency", "damping"]
    rows = list(csv.DictReader(page.execute_script("return backbonesAsCsv()").splitlines()))
    assert len(rows) == len(drawn[0]["x"])
    assert float(rows[3]["frequency_Hz"]) == pytest.approx(drawn[0]["y"][3], rel=1e-6)
    assert rows[0]["harmonics"] == "one harmonic"


@pytest.fixture
def view(page):
    page.execute_script("document.getElementById('view-open').click()")
    find = "return document.getElementById('view').dataset.ready"
    wait_for(page, lambda: page.execute_script(find))
    page.execute_script(
        "document.getElementById('view-plot').scrollIntoView("
        "{block: 'center', behavior: 'instant'})"
    )
    return page


def test_the_view_draws_mesh_modes_and_contact(view):
    names = [each["name"] for each in view.execute_script(DATA, "view-plot")]
    assert {"bar A", "bolt 1", "mesh", "contact"} <= set(names) and "bar B" not in names
    shapes = [each.text for each in view.find_elements("css selector", "#view-shape option")]
    assert shapes[:2] == ["at rest", "under preload"]
    assert shapes[2].startswith("mode 1, without contact: ")
    assert any(each.startswith("mode 1, sticking: ") for each in shapes)
    assert shapes[-1] == "deflection at the peak"

    def heights():
        return view.execute_script(
            "return Array.from(document.getElementById('view-plot').data[0].z)"
        )

    at_rest = heights()
    choose(view, "view-shape", "peak")
    choose(view, "view-colour", "state")
    assert max(map(abs, heights())) > 1.2 * max(map(abs, at_rest))
    assert "drawn" in view.find_element("id", "view-scale").text
    bar = view.execute_script(
        "return document.getElementById('view-plot').data.find(each => each.colorbar)"
        ".colorbar.title.text"
    )
    assert bar == "contact state at 0.01 N"


def test_the_loop_of_the_whole_joint_is_drawn_until_a_pair_is_picked(view):
    choose(view, "view-peak", "1")
    assert "The whole joint at the peak at 20 N" in view.find_element("id", "pair-facts").text
    (loop,) = view.execute_script(DATA, "loop-plot")
    assert loop["name"] == "joint" and len(loop["x"]) == 49
    rows = list(csv.DictReader(view.execute_script("return loopAsCsv()").splitlines()))
    assert float(rows[5]["displacement_mm"]) == pytest.approx(loop["x"][5], rel=1e-6)
    assert float(rows[5]["friction_force_N"]) == pytest.approx(loop["y"][5], rel=1e-6)


def test_a_pair_that_is_picked_tells_its_load_state_and_loop(view):
    box = view.execute_script(
        "const box = document.getElementById('view-plot').getBoundingClientRect();"
        "return [box.left, box.top, box.width, box.height]"
    )
    facts = ""
    for column in range(24):
        at = box[0] + box[2] * (0.3 + 0.015 * column), box[1] + box[3] / 2
        mouse(view, at)
        time.sleep(0.15)
        mouse(view, at, press=True)
        time.sleep(0.15)
        facts = view.find_element("id", "pair-facts").text
        if facts.startswith("Pair"):
            break
    assert re.match(r"Pair \d+ at \(.*\) mm", facts)
    # of a pair under load, by its number
    pair = view.execute_script(
        "return space.load.indexOf(space.load.reduce((a, b) => Math.max(a, b)))"
    )
    view.execute_script("pick(arguments[0]);", pair)
    choose(view, "view-peak", "1")
    facts = view.find_element("id", "pair-facts").text
    assert "slip force" in facts and "at the peak at 20 N: " in facts
    (loop,) = view.execute_script(DATA, "loop-plot")
    assert len(loop["x"]) == 49
    assert view.find_element("id", "loop-plot").is_displayed()


WIDER = (
    "document.querySelectorAll('details').forEach(each => { each.open = true; });"
    "return [document.documentElement, ...document.querySelectorAll('main *')].filter("
    "each => each.clientWidth && each.scrollWidth > each.clientWidth + 1"
    " && getComputedStyle(each).display !== 'inline' && !each.closest('.plot, svg')"
    ").map(each => [each.tagName, each.scrollWidth, each.clientWidth,"
    " (each.closest('figure') || each).id])"
)


@pytest.mark.parametrize(("width", "media"), [(1440, "screen"), (800, "screen"), (720, "print")])
def test_nothing_is_wider_than_its_room(browser, finished, width, media):
    """Of 720 pixels is a sheet of A4 within its margins."""
    browser.set_window_size(width, 900)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": media})
    try:
        for path in sorted((finished / "results/report").glob("*.html")):
            browser.get(path.as_uri())
            if 'id="curves"' in path.read_text():
                wait_for(browser, lambda: browser.execute_script(READY))
            assert browser.execute_script(WIDER) == [], path.name
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
        browser.set_window_size(1400, 900)


def test_tables_of_a_page_have_titles_of_their_own(finished):
    for path in sorted((finished / "results/report").glob("*.html")):
        titles = re.findall(
            '<figure class="tabular".*?<strong>(.*?)</strong>', path.read_text(), re.S
        )
        assert titles, path.name
        assert sorted(set(titles)) == sorted(titles), path.name


def test_the_overview_has_a_picture_and_a_response_of_each_case(finished):
    page = (finished / "results/report/overview.html").read_text()
    assert page.count('id="mesh_two_bolt"') == 1
    for name, basis in (("small", "enriched-8"), ("variable", "free-2")):
        anchor = f"response_{name}_{basis}_node-to-node_linear_resonance=1"
        assert page.count(f'id="{anchor}"') == 1
    lead = " ".join(re.sub("<.*?>", " ", page.split("</header>")[0]).split())
    assert "damping is largest near" in lead
    assert re.search(r"Slip shows in the frequency from about [\d.]+ N on", lead)
