"""Text from files never becomes markup, a path, or a part of a model."""

import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from html.parser import HTMLParser
from unittest.mock import patch

import mujoco
import pytest
from markdown_it import MarkdownIt
from mutated_scenes import LEAST, Raw, written
from page import read_page
from spincheck.engines.models.mjcf import mjcf
from spincheck.engines.models.urdf import urdf
from spincheck.reports.cli import choosing
from spincheck.reports.cli.run import running
from spincheck.reports.cli.scenes.scene import model_files
from spincheck.reports.harness.executors import InProcess
from spincheck.reports.pages.markdown import escaped
from spincheck.reports.pages.render import render
from spincheck.reports.pages.templating import to_html
from spincheck.reports.results.cost_records import MethodCost, Ratio, StepCost
from spincheck.reports.results.records import Key, variation
from spincheck.reports.results.results import SceneResult
from spincheck.scenarios import ScenarioError, is_scene_name, load, loads

#: Each would be seen as an element, an attribute or a link called "evil" if it were let through.
HOSTILE = (
    "<evil>",
    "</script><evil onclick=evil()>",
    "\"><evil title='",
    "' onmouseover='evil()",
    "<img src=x onerror=evil()>",
    "[evil](javascript:evil)",
    "![evil](evil.png)",
    "<javascript:evil>",
    "&lt;evil&gt;&#60;evil&#62;",
    "]]><evil/>",
    "--><evil>",
    "{{ 7 * 7 }}{% raw %}",
    "``` <evil>",
    "| evil | evil |",
)
TEXT = " ".join(HOSTILE)
#: Of an engine and a method that chose their own names.
KEY = Key("made", TEXT, TEXT)


class Structure(HTMLParser):
    """The elements of a page, their attributes' names, and where they point to."""

    def __init__(self) -> None:
        super().__init__()
        self.elements: set[tuple[str, str]] = set()
        self.targets: list[str] = []
        self.json: list[str] = []
        self._in_json = False

    def handle_starttag(self, tag, attributes) -> None:
        self.elements |= {(tag, name) for name, _ in attributes} | {(tag, "")}
        self.targets += [value or "" for name, value in attributes if name in ("href", "src")]
        self._in_json = (tag, ("type", "application/json")) == (tag, *attributes[:1])

    def handle_endtag(self, tag) -> None:
        self._in_json = False

    def handle_data(self, data) -> None:
        if self._in_json:
            self.json.append(data)


def structure(html: str) -> Structure:
    parser = Structure()
    parser.feed(html)
    parser.close()
    return parser


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clean")
    (folder / "made.toml").write_text(written(LEAST))
    out = folder / "clean.sqlite"
    scene = [str(folder / "made.toml")]
    with patch.object(choosing, "LocalWorkers", lambda *_: InProcess()):
        return running.run(scene, ["mujoco"], ["RK4"], [], 1, out, quick=True)


COST = StepCost(2e-6, 1e-7, 2e-6, ratio=Ratio(2.0, 0.1))


def hostile_scene():
    text = json.dumps(TEXT, ensure_ascii=False)
    file = {
        **LEAST,
        **dict.fromkeys(("title", "source", "description"), Raw(text)),
        "tags": Raw(f"[{text}]"),
    }
    return loads(written(file), "made")


@pytest.fixture(scope="module")
def hostile(results):
    """The same study, of a scene and an engine with hostile texts, which printed some."""
    (scene_result,) = results.scenes.values()

    def renamed(record):
        return replace(record, key=replace(record.key, engine=TEXT))

    return replace(
        results,
        environment=results.environment | {TEXT: TEXT},
        scenes={"made": SceneResult(hostile_scene(), scene_result.solution)},
        rows=[replace(renamed(row), reason=TEXT, printed=TEXT) for row in results.rows],
        verdicts=[replace(renamed(v), quoted=TEXT, unmet=(TEXT,)) for v in results.verdicts],
        costs=[
            MethodCost(KEY, "", COST, variation({"left_in": left_in}), difference)
            for left_in, difference in (([TEXT, "another"], 0.0), ([TEXT], None))
        ],
    )


@pytest.fixture(scope="module")
def pages(results, hostile, tmp_path_factory):
    """The clean report and the hostile one, page by page."""
    folders = [tmp_path_factory.mktemp(name) for name in ("clean", "hostile")]
    for report_results, folder in zip((results, hostile), folders, strict=True):
        render(report_results, folder)
    return folders


@pytest.mark.parametrize("page", ["index.html", "scenes/made.html"])
def test_no_element_and_no_attribute_of_a_page_comes_from_a_text(pages, page):
    clean, bad = (structure((folder / page).read_text(encoding="utf-8")) for folder in pages)
    # Emphasis, code and tables are what a description may have.
    markdown = {(tag, "") for tag in ("p", "em", "strong", "code", "pre", "ul", "li", "table")}
    marks = {(tag, "") for tag in ("details", "summary", "span", "h3", "ol")}
    new = {element for element in bad.elements - clean.elements if element not in markdown | marks}
    assert not {tag for tag, _ in new if tag == "evil"}
    assert not {name for _, name in new if name.startswith("on")}
    assert not [target for target in bad.targets if re.match(r"(?i)\s*(javascript|data):", target)]
    assert not [target for target in bad.targets if "evil.png" in target]


@pytest.mark.parametrize("page", ["index.html", "scenes/made.html"])
def test_templates_are_not_expanded_twice(pages, page):
    assert "49" not in re.findall(r"evil\W+(49)", (pages[1] / page).read_text(encoding="utf-8"))


def test_a_figures_data_are_whole_and_hold_no_markup_of_the_texts(pages):
    items = read_page(pages[1] / "scenes" / "made.html").packed
    figures = [item for item in items if isinstance(item, dict) and "data" in item]
    assert figures
    for figure in figures:
        assert "<evil" not in json.dumps([_shown(trace) for trace in figure["data"]])


def _shown(trace):
    """What of a trace plotly reads as HTML."""
    return {name: trace.get(name) for name in ("name", "text", "hovertext", "hovertemplate")}


@pytest.mark.parametrize("page", ["report.md", "scenes/made.md"])
def test_markdown_pages_hold_no_html_of_the_texts(pages, page):
    text = (pages[1] / page).read_text(encoding="utf-8")
    rendered = structure(MarkdownIt("commonmark", {"html": True}).enable("table").render(text))
    assert "evil" not in {tag for tag, _ in rendered.elements}
    assert not [name for _, name in rendered.elements if name.startswith("on")]
    assert not [target for target in rendered.targets if "evil" in target]


@pytest.mark.parametrize("text", HOSTILE)
def test_a_line_of_markdown_shows_the_text_itself(text):
    rendered = structure(MarkdownIt("commonmark").enable("table").render(f"x {escaped(text)}"))
    assert rendered.elements == {("p", "")}


@pytest.mark.parametrize("text", [*HOSTILE, "<http://evil.org>", "[x]: http://evil.org\n\n[x]"])
def test_a_description_links_to_nothing_and_loads_nothing(text):
    rendered = structure(to_html(text))
    assert not rendered.targets
    assert all(tag != "evil" and not name.startswith("on") for tag, name in rendered.elements)


def test_the_model_of_a_hostile_scene_is_that_of_a_harmless_one(tmp_path):
    harmless, scene = loads(written(LEAST), "made"), hostile_scene()
    assert mjcf(scene, 0.01, "RK4") == mjcf(harmless, 0.01, "RK4")
    assert urdf(scene) == urdf(harmless)


@pytest.mark.parametrize("name", ["a.b", "é", "中文", "x" * 200, "0"])
def test_whatever_name_a_scene_may_have_its_models_have_too(name):
    models = model_files(loads(written(LEAST), name))
    for text in models.values():
        root = ET.fromstring(text)
        assert name in (root.get("model"), root.get("name"))
    assert mujoco.MjModel.from_xml_string(models["scene.xml"]).nbody


SHORT = r"""
.. ..%2f.. %2e%2e <script> a&b a'b a"b -x .x a/b a\b con: ~ a?b a#b *
"""
LONGER = ["x" * 201, "é" * 101, "\x1b[31m", "a\x00b", "a\u202eb", "a b", "a\nb", ""]
BAD_NAMES = [*SHORT.split(), *LONGER]


@pytest.mark.parametrize("name", BAD_NAMES, ids=ascii)
def test_a_name_that_could_be_more_than_a_name_is_refused_in_one_line(tmp_path, name):
    assert not is_scene_name(name)
    with pytest.raises(ScenarioError) as complaint:
        loads(written(LEAST), name)
    assert str(complaint.value).isprintable()
    # Of those that a file can have, the file's own.
    if name not in ("", "..") and not set(name) & set("/\0"):
        (tmp_path / f"{name}.toml").write_text(written(LEAST))
        with pytest.raises(ScenarioError, match="a scenario's name is its file's stem"):
            load(tmp_path / f"{name}.toml")


def test_planted_markup_is_seen():
    """The teeth: what the properties above look for is found where it is let through."""
    page = structure("".join(f"<p>{text}</p>" for text in HOSTILE))
    assert {("evil", "onclick"), ("img", "onerror")} <= page.elements
    links = MarkdownIt("commonmark", {"html": True}).render(TEXT)
    assert "evil.png" in structure(links).targets
