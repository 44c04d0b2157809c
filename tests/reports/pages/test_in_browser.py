"""Every page of a real report, in a real browser: it draws, answers, fits, and loads nothing."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import made_up_ensembles
import numpy as np
import pytest
from spincheck.engines import engines
from spincheck.reports.harness.choice import Choice
from spincheck.reports.pages.render import render
from spincheck.reports.pages.scene.motion_data import EXACT_STEP
from spincheck.scenarios import find, load
from studies import study

pytest.importorskip("playwright", reason="playwright is not installed")
from browser import chromium, launched
from page import read_page
from playwright.sync_api import Browser, Locator, Page, expect
from plotted import values_of

CHROMIUM = chromium()
pytestmark = [
    pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed"),
    pytest.mark.slow,
]

SCENES = ("wheel-in-a-box", "fast-top", "hammer", "reaction-wheel")
METHODS = ("default", "RK4", "multibody")
#: Steps: short ladders, whose pages are made of the same parts.
BUDGET = 1 << 11
DESK, PHONE = {"width": 1280, "height": 900}, {"width": 400, "height": 800}
#: Pixels (96 an inch) of the text on A4, 210 mm less two margins of 12.
PAPER = 186 / 25.4 * 96
#: ms; as much as a busy machine may need.
PATIENCE = 60_000
#: Bytes.
LARGEST_REPORT = 25e6


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A report of real runs, timed, of a scene of each kind and a hard one; with an ensemble."""
    folder = tmp_path_factory.mktemp("browsed")
    installed = [engine for name, engine in engines().items() if name in ("mujoco", "pybullet")]
    choice = Choice(tuple(installed), METHODS, max_steps=BUDGET)
    results = study(folder / "results.sqlite", [load(path) for path in find(SCENES)], choice)
    render(replace(results, ensembles=made_up_ensembles.at_stock().ensembles), folder / "report")
    return folder / "report"


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with launched(str(CHROMIUM)) as browser:
        yield browser


@dataclass
class Visit:
    """A page that is open, the errors it has logged since, and the addresses it has requested."""

    page: Page
    errors: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)


@pytest.fixture
def visit(browser: Browser) -> Iterator[Visit]:
    page = browser.new_page(viewport=DESK)
    page.set_default_timeout(PATIENCE)
    visited = Visit(page)
    page.on("console", lambda m: visited.errors.append(m.text) if m.type == "error" else None)
    page.on("pageerror", lambda error: visited.errors.append(str(error)))
    page.on("request", lambda request: visited.requests.append(request.url))
    yield visited
    page.close()


def open_page(visit: Visit, folder: Path, name: str = "index.html") -> Page:
    visit.page.goto((folder / name).as_uri(), wait_until="domcontentloaded")
    return visit.page


def open_table(visit: Visit, folder: Path) -> Page:
    """The first page without its figures, which its table does not need."""
    visit.page.route("**/plotly.js", lambda route: route.abort())
    return open_page(visit, folder)


#: Comes past every figure, as a reader does, and waits until it is drawn.
PASS_BY = """async (patience) => {
  for (const one of document.querySelectorAll("details")) one.open = true;
  for (const plot of document.querySelectorAll(".plot")) {
    plot.scrollIntoView();
    for (const end = Date.now() + patience; !plot.querySelector(".main-svg"); ) {
      if (Date.now() > end) throw new Error(`not drawn: ${plot.outerHTML.slice(0, 200)}`);
      await new Promise((resolve) => setTimeout(resolve, 5));
    }
  }
}"""


def draw(plot: Locator) -> None:
    """Come past a figure."""
    plot.scroll_into_view_if_needed()
    plot.locator(".main-svg").first.wait_for(state="attached")


def widest(page: Page) -> int:
    return page.evaluate("document.documentElement.scrollWidth")


def test_every_page_draws_its_figures_fits_a_desk_and_a_phone_and_asks_for_nothing(visit, folder):
    too_wide, windows = [], [DESK, PHONE]
    for path in sorted(folder.rglob("*.html")):
        page = open_page(visit, folder, str(path.relative_to(folder)))
        page.evaluate(PASS_BY, PATIENCE)
        for window in windows:
            page.set_viewport_size(window)
            if (width := widest(page)) > window["width"]:
                too_wide.append(f"{path.name}: {width} of {window['width']}")
        # The next page is drawn in this window: each change of its size draws all figures again.
        windows.reverse()
    assert too_wide == []
    assert visit.errors == []
    assert [url for url in visit.requests if not url.startswith(("file:", "data:", "blob:"))] == []


def test_what_a_page_says_and_asks_for_is_noticed(visit, folder):
    page = open_page(visit, folder)
    page.evaluate("console.error('wrong'); fetch('http://127.0.0.1:9/x').catch(() => 0)")
    page.wait_for_timeout(100)
    assert any("wrong" in line for line in visit.errors)
    assert "http://127.0.0.1:9/x" in visit.requests


def cell(page: Page, scene: str, column: str) -> str:
    """The text of the first table's cell in a scene's row, below a heading."""
    headings = page.locator("#heat thead tr:last-child button").all_inner_texts()
    index = next(k for k, text in enumerate(headings) if text.startswith(column))
    return rows(page)[scene][index]


def rows(page: Page) -> dict[str, list[str]]:
    """The first table's rows of scenes in order, by name."""
    table_rows = page.evaluate(
        "[...document.querySelectorAll('#heat tbody tr')].filter(r => r.cells.length > 1)"
        ".map(r => [...r.cells].map(c => c.innerText.trim()))"
    )
    return {row[0]: row for row in table_rows}


def test_the_first_screen_answers_what_the_default_gets_wrong_on_a_top(visit, folder):
    page = open_table(visit, folder)
    expect(page.locator(".answer").nth(0)).to_contain_text("mujoco default 13°")
    expect(page.locator("#answer table").first).to_contain_text("use mujoco RK4")
    assert cell(page, "fast-top", "mujoco").endswith("13°")
    best = cell(page, "fast-top", "cheapest")
    assert "mujoco RK4" in best
    assert best.endswith("×")
    box = page.locator("#heat tbody tr", has_text="fast-top").bounding_box()
    assert box["y"] + box["height"] < DESK["height"]


def test_cells_switch_between_signals_and_timesteps(visit, folder):
    page = open_table(visit, folder)
    at_stock = cell(page, "fast-top", "mujoco")
    page.locator("label", has_text="1 ms").click()
    at_common = cell(page, "fast-top", "mujoco")
    # Of first order in a halved timestep.
    assert float(at_common.strip("°? ")) < 0.7 * float(at_stock.strip("°? "))
    page.locator("label", has_text="ω").click()
    assert "°" not in cell(page, "fast-top", "mujoco")
    page.locator("label", has_text="CPU time").click()
    expect(page.locator("#unit")).to_contain_text("CPU seconds")


def test_filters_leave_the_scenes_that_match(visit, folder):
    page = open_table(visit, folder)
    page.locator("#find").fill("top")
    assert set(rows(page)) == {"fast-top"}
    page.locator("#find").fill("")
    for control, value, left in (("#kind", "Thrown", "hammer"), ("#tag", "hard", "reaction-wheel")):
        page.locator(control).select_option(value)
        assert set(rows(page)) == {left}
        page.locator(control).select_option("")


def test_a_verdict_chosen_leaves_the_scenes_where_any_method_got_it(visit, folder):
    page = open_table(visit, folder)
    carried = page.evaluate("spincheck.items[document.querySelector('#packed').dataset.heat]")
    carried_pairs = {
        s["name"]: {cell["verdict"] for cell in s["cells"] if cell} for s in carried["scenes"]
    }
    for word in set.union(*carried_pairs.values()):
        page.locator("#verdict").select_option(word)
        assert set(rows(page)) == {name for name, words in carried_pairs.items() if word in words}


@pytest.mark.needs_pybullet
def test_the_engine_chosen_alone_has_columns_and_the_best_choice(visit, folder):
    page = open_table(visit, folder)
    page.locator("#engine").select_option("pybullet")
    headings = page.locator("#heat thead tr:last-child button").all_inner_texts()
    assert [text.split()[0] for text in headings] == ["scene", "pybullet", "multibody", "cheapest"]
    assert "pybullet" in cell(page, "fast-top", "cheapest")


def test_a_heading_sorts_and_sorts_back(visit, folder):
    page = open_table(visit, folder)
    in_groups = list(rows(page))
    heading = page.locator("#heat thead button", has_text="RK4")
    orders = []
    for _ in range(3):
        heading.click()
        orders.append(list(rows(page)))
    plain = len(SCENES) - 1
    assert orders[0][:plain] == orders[1][:plain][::-1]
    assert orders[2] == in_groups


def test_the_table_unfolds_hard_scenes_and_is_walked_with_arrow_keys(visit, folder):
    """And tells each run."""
    page = open_table(visit, folder)
    assert "reaction-wheel" not in rows(page)
    page.locator(".folded button").click()
    assert "reaction-wheel" in rows(page)
    expect(page.locator(".folded button")).to_be_focused()
    page.locator("#heat tbody a[tabindex='0']").focus()
    page.keyboard.press("ArrowRight")
    expect(page.locator("#detail")).to_contain_text("fast-top, mujoco default")
    page.keyboard.press("ArrowDown")
    expect(page.locator("#detail")).to_contain_text(re.compile("^wheel-in-a-box, mujoco.* spins "))
    page.keyboard.press("Enter")
    page.wait_for_url("**/scenes/wheel-in-a-box.html*")


def test_colours_follow_the_dark_scheme(visit, folder):
    page = open_table(visit, folder)
    colour = "getComputedStyle(document.querySelector('#heat tbody td')).backgroundColor"
    light = page.evaluate(colour)
    page.emulate_media(color_scheme="dark")
    page.wait_for_function(f"{colour} !== '{light}'")


def test_play_moves_the_body_and_pause_holds_it(visit, folder):
    page = open_page(visit, folder, "scenes/fast-top.html")
    # The pixels of the exact motion's picture.
    picture = "document.querySelector('.player canvas').toDataURL()"
    page.locator("[data-clock]").filter(has_text="of").wait_for()
    at_rest = page.evaluate(picture)
    play = page.locator("[data-play]")
    play.click()
    page.wait_for_function("before => " + picture + " !== before", arg=at_rest)
    play.click()
    expect(play).to_have_attribute("aria-pressed", "false")
    held = page.evaluate(picture)
    page.wait_for_timeout(100)
    assert page.evaluate(picture) == held


def test_the_error_shown_is_that_of_the_time_shown(visit, folder):
    page = open_page(visit, folder, "scenes/fast-top.html")
    page.locator("[data-run]").select_option(label="mujoco default at 2 ms")
    error = page.locator("[data-difference]")
    expect(error).to_have_text(re.compile("^attitude error ≤ [0-9.]+×10⁻"))
    page.locator("[data-time]").fill("1")
    expect(page.locator("[data-clock]")).to_have_text("5 of 5 s")
    # The worst moment of this run is its last: what the page's first sentence says.
    expect(page.locator(".headline")).to_contain_text("MuJoCo default at 2 ms is off by 13.2°")
    expect(error).to_have_text("attitude error 13°")


def test_the_script_restores_the_arrays_that_the_page_carries(visit, folder):
    page = open_page(visit, folder, "scenes/fast-top.html")
    written = read_page(folder / "scenes" / "fast-top.html")
    exact = written.motions["exact"]
    ours = [written.restored(component).tolist() for component in exact["omega_body"]]
    theirs = page.evaluate("spincheck.motions.exact.omega")
    assert [list(row) for row in zip(*ours, strict=True)] == theirs


def test_the_script_draws_the_exact_axis_on_the_sphere_from_where_the_dot_is(visit, folder):
    page = open_page(visit, folder, "scenes/fast-top.html")
    draw(page.locator("#axis .plot").first)
    drawn = page.evaluate("document.querySelector('#axis .plot').data")
    (line,) = (trace for trace in drawn if trace.get("name") == "exact")
    (dot,) = (trace for trace in drawn if trace["mode"] == "markers")
    points = np.array([[float(v) for v in _values(line[axis])] for axis in "xyz"])
    start = [_values(dot[axis])[0] for axis in "xyz"]
    # Quaternions are carried to 2⁻¹⁷, which turns a unit vector by up to four times as much.
    slack = 4 * EXACT_STEP
    np.testing.assert_allclose(np.linalg.norm(points, axis=0), 1.0, atol=slack)
    np.testing.assert_allclose(points[:, 0], start, atol=slack)


def _values(carried) -> list[float]:
    """Numbers of a trace, which Plotly keeps as they were given."""
    return values_of(carried).tolist() if "bdata" in carried else list(carried)


def test_another_run_is_drawn_beside_the_same_exact_motion(visit, folder):
    page = open_page(visit, folder, "scenes/fast-top.html")
    expect(page.locator("[data-run] option").first).to_be_attached()
    page.locator("[data-time]").fill("0.5")
    before = pictures(page)
    chosen = page.locator("[data-run] option:not(:checked)").last
    page.locator("[data-run]").select_option(chosen.get_attribute("value"))
    after = pictures(page)
    assert (before[0] == after[0], before[1] == after[1]) == (True, False)


def pictures(page: Page) -> list[str]:
    """What the player's two canvases show."""
    return page.eval_on_selector_all(".player canvas", "all => all.map((one) => one.toDataURL())")


def test_a_page_answers_first_and_draws_figures_and_tables_as_the_reader_comes_near(visit, folder):
    page = open_page(visit, folder, "scenes/fast-top.html")
    page.locator("[data-clock]").filter(has_text="of 5").wait_for()
    assert page.evaluate("typeof Plotly") == "undefined"
    draw(page.locator(".plot").first)
    runs = page.locator("#runs details.method").first
    expect(runs.locator("td")).to_have_count(0)
    runs.locator("summary").first.click()
    expect(runs.locator("td").first).to_be_visible()


def test_a_page_that_is_printed_as_it_opens_has_every_figure_as_wide_as_the_paper(visit, folder):
    page = open_page(visit, folder, "scenes/fast-top.html")
    printed = "() => { dispatchEvent(new Event('beforeprint')); return %s; }"
    of_every_figure = "[...document.querySelectorAll('.plot')].map(%s)"
    room_left = "d => d.clientWidth - (d.querySelector('.main-svg')?.clientWidth ?? Infinity)"
    room = page.evaluate(printed % (of_every_figure % room_left))
    assert len(room) > 10
    assert set(room) == {0}
    assert page.locator("main").bounding_box()["width"] == pytest.approx(PAPER, abs=1)


def test_the_library_s_report_stays_below_25_mb(folder):
    """As many pages as the library has scenes, of the size of these and of their Markdown."""
    scenes = len(find([]))
    pages = [path.stat().st_size for path in (folder / "scenes").iterdir()]
    once = sum(path.stat().st_size for path in (folder / "assets").iterdir())
    first = sum((folder / name).stat().st_size for name in ("index.html", "report.md"))
    assert once + (sum(pages) + first) * scenes / len(SCENES) < LARGEST_REPORT


def test_the_address_carries_the_filters_and_a_search_without_hits_says_so(visit, folder):
    page = open_table(visit, folder)
    page.locator("#find").fill("hammer")
    page.locator("#tag").select_option("hard")
    expect(page.locator("#heat tbody")).to_contain_text("No scene matches find “hammer” and tag")
    again = page.url
    page.goto("about:blank")
    page.goto(again, wait_until="domcontentloaded")
    assert page.locator("#find").input_value() == "hammer"
    page.locator("#heat tr.none button").click()
    assert {"fast-top", "hammer"} <= set(rows(page))
    assert "=" not in page.url


@pytest.mark.parametrize("name", ["index.html", "scenes/fast-top.html"])
def test_the_first_error_is_in_sight_on_a_phone(visit, folder, name):
    page = open_page(visit, folder, name)
    page.set_viewport_size(PHONE)
    place = "#heat tbody td" if name == "index.html" else ".given tbody td.number"
    box = page.locator(place).first.bounding_box()
    assert box["x"] + box["width"] <= PHONE["width"]


def test_a_click_on_what_to_type_selects_all_of_it(visit, folder):
    page = open_page(visit, folder, "scenes/fast-top.html")
    page.locator(".best .command").first.click()
    selected = page.evaluate("getSelection().toString()")
    assert 'integrator="RK4"' in selected
    assert "model.opt.timestep" in selected
