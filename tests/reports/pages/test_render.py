"""The report as files: complete, well formed, self-contained, safe, and the same every time."""

import base64
import re
import zlib
from dataclasses import replace
from pathlib import Path
from urllib.parse import unquote

import pytest
from case_loops import each_case
from contrast import contrast
from made_up import METHODS, MISCHIEF, PRINTED, UNCERTAINTY, MadeUp, results
from markdown_text import markdown_tables, outside_code, plain
from page import Page, read_page, unsound
from spincheck.reports.pages.analysis.cost_to_reach import LEVELS
from spincheck.reports.pages.analysis.report_data import report_data
from spincheck.reports.pages.analysis.wording import NOTHING, number
from spincheck.reports.pages.overview.overview import complaints, headline
from spincheck.reports.pages.render import render
from spincheck.reports.pages.scene import scene_tables
from spincheck.reports.pages.templating import source
from spincheck.reports.results.results import SceneResult
from spincheck.reports.results.verdict_words import VERDICT
from spincheck.reports.results.verdicts import Verdict
from spincheck.scenarios import SIGNAL

pytestmark = pytest.mark.slow

#: Bytes; what a page may weigh.
HEAVIEST_PAGE = 2e5
#: WCAG 2.1, 1.4.3: contrast of text.
AA = 4.5


@pytest.fixture(scope="module")
def pages(folder: Path) -> dict[str, Page]:
    paths = [folder / "index.html", *sorted((folder / "scenes").glob("*.html"))]
    return {path.stem: read_page(path) for path in paths}


VERDICTS = results().verdicts
every_verdict = each_case(
    "verdict", {f"{v.key.scenario} {v.key.engine} {v.key.method}": v for v in VERDICTS}
)


@every_verdict
def test_every_pair_has_a_cell_that_leads_to_its_row(
    pages: dict[str, Page], verdict: Verdict
) -> None:
    key = verdict.key
    sign = VERDICT[verdict.verdict].sign if verdict.verdict != "converges" else ""
    cells = [
        link.attributes["href"]
        for link in pages["index"].all("a")
        if link.attributes["href"].startswith(f"scenes/{key.scenario}.html#")
        and link.text.startswith(sign)
    ]
    rows = {e.attributes.get("id"): e.text for e in pages[key.scenario].all("tr")}
    assert any(
        key.engine in rows[target] and key.method in rows[target]
        for target in (link.partition("#")[2] for link in cells)
    )


@every_verdict
def test_reasons_and_what_a_verdict_rests_on_are_on_the_pages(
    pages: dict[str, Page], folder: Path, verdict: Verdict
) -> None:
    cells = pages[verdict.key.scenario].all("td")
    reasons = [*([verdict.reason] if verdict.verdict != "converges" else []), *verdict.unmet]
    for reason in reasons:
        first = (cell for table in pages["index"].tables() for row in table for cell in row)
        assert any(reason in cell for cell in first)
        assert any(reason in cell.text for cell in cells)
        for path in (folder / "report.md", folder / "scenes" / f"{verdict.key.scenario}.md"):
            assert plain(reason) in plain(path.read_text(encoding="utf-8"))
    assert bool(verdict.ground) == (verdict.verdict == "converges")
    assert any(verdict.verdict in c.text and verdict.ground in c.text for c in cells)


def test_the_headline_counts_what_is_there(pages: dict[str, Page]) -> None:
    headline = next(p.text for p in pages["index"].all("p") if "Of " in p.text)
    verdict_words = [v.verdict for v in VERDICTS]
    assert f"3 scenes × {len(METHODS)} methods. Of {len(verdict_words)} pairs" in headline
    assert f"{verdict_words.count('converges')} converge to the exact motion" in headline
    assert f"{verdict_words.count('failed')} failed" in headline


def test_the_first_page_has_a_table_of_costs(pages: dict[str, Page], folder: Path) -> None:
    """That ends in a column for each level."""
    assert {"costs"} <= {*pages["index"].attribute("id")}
    for tables in (pages["index"].tables(), markdown_tables(folder / "report.md")):
        heads = [table[0][-len(LEVELS) :] for table in tables if table and table[0]]
        levels = [h for h in heads if len(h) == len(LEVELS) and all("to " in cell for cell in h)]
        assert len(levels) == 1


def test_where_no_run_was_timed_it_has_none_and_says_so(tmp_path: Path) -> None:
    stored = results()
    rows = [replace(row, seconds_per_step=None) for row in stored.rows]
    index = render(replace(stored, rows=rows), tmp_path)
    assert "No run was timed" in index.read_text(encoding="utf-8")
    assert "No run was timed" in (tmp_path / "report.md").read_text(encoding="utf-8")
    assert "(0 scenes)" not in (tmp_path / "report.md").read_text(encoding="utf-8")


def test_an_error_that_is_zero_has_no_order() -> None:
    stored = results()
    rows = [
        replace(row, errors=replace(row.errors, com=0.0)) if row.errors else row
        for row in stored.rows
    ]
    (scene, *_) = report_data(replace(stored, rows=rows)).scenes
    table = scene_tables.signals_table(scene)
    signal, error, order = map(table.headings.index, ("signal", "error", "order found"))
    of_com = [row for row in table.rows if row[signal].text.startswith("com")]
    assert of_com
    assert {(row[error].text, row[order].text) for row in of_com} == {("0", NOTHING)}


def test_pages_are_well_formed_and_every_link_leads_somewhere_in_the_report(folder: Path) -> None:
    assert unsound(folder) == {}
    assert "url(" not in (folder / "assets" / "style.css").read_text(encoding="utf-8")


def test_what_is_wrong_with_a_page_is_found(tmp_path: Path) -> None:
    links = ("https://a.org", "none.html", "#nowhere", "bad.html#x")
    text = "<p id='x'><b id='x'>bold</p><td class='a' class='b'>"
    (tmp_path / "bad.html").write_text(text + "".join(f"<a href='{link}'></a>" for link in links))
    faults = "; ".join(unsound(tmp_path)["bad.html"])
    assert "attribute twice" in faults
    assert "id x twice" in faults
    assert "nowhere in the report: https://a.org" in faults
    assert "nowhere in the report: none.html" in faults
    assert "no such place: #nowhere" in faults
    assert "bad.html#x" not in faults


def test_plotly_is_written_once_and_told_to_send_nothing(folder: Path) -> None:
    written = [path for path in folder.rglob("*") if path.is_file()]
    large = [path for path in written if "packedPlotly =" in path.read_text(encoding="utf-8")]
    assert [path.name for path in large] == ["plotly.js"]
    packed = large[0].read_text(encoding="utf-8").split('"')[1]
    assert b"plotly.js v" in zlib.decompress(base64.b64decode(packed))[:1000]
    script = (folder / "assets" / "figures.js").read_text(encoding="utf-8")
    assert "showSendToCloud: false" in script
    assert 'plotlyServerURL: ""' in script
    # The first page has no figure.
    scripts = read_page(folder / "index.html").attribute("src")
    assert [Path(src).name for src in scripts if "plotly" in src] == []


def test_what_users_wrote_is_shown_and_stays_text(pages: dict[str, Page], folder: Path) -> None:
    for page in pages.values():
        assert MISCHIEF not in page.path.read_text(encoding="utf-8")
        assert not page.all("img")
    for path in folder.rglob("*.md"):
        assert MISCHIEF not in outside_code(path)
    page = pages["made-up-top"]
    assert all(MISCHIEF in page.all(tag)[0].text for tag in ("title", "h1"))
    assert all(any(MISCHIEF in part.text for part in page.all(tag)) for tag in ("pre", "p"))
    # So is what an engine printed.
    assert PRINTED in [element.text for element in page.all("pre")]
    assert PRINTED in (folder / "scenes" / "made-up-top.md").read_text(encoding="utf-8")
    # Markdown in a description is rendered.
    assert [e.text for e in page.all("strong")] == ["fast"]


def test_no_error_is_printed_below_the_reference_and_one_at_that_limit_says_so(
    pages: dict[str, Page],
) -> None:
    page = pages["made-up-top"]
    assert _errors_too_small(page) == []
    cells = [text for table in page.tables() for row in table for text in row]
    assert f"≤ {number(UNCERTAINTY.omega)}" in cells
    assert "reference limit" in " ".join(p.text for p in page.all("p"))


def test_an_error_printed_below_the_reference_would_be_seen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    unlimited = lambda errors, _, names: tuple(number(errors[n]) for n in names)  # noqa: E731
    monkeypatch.setattr(scene_tables, "limited_errors", unlimited)
    render(results(), tmp_path)
    assert _errors_too_small(read_page(tmp_path / "scenes" / "made-up-top.html")) != []


def test_every_run_is_in_the_table_of_its_method(pages: dict[str, Page]) -> None:
    for name in ("made-up-top", "made-up-brick", "unsolved"):
        tables = [t for t in pages[name].tables() if t[0][0] == "timestep, s"]
        rows = [row for row in results().rows if row.key.scenario == name]
        assert sum(len(table) - 1 for table in tables) == len(rows)
        assert len(tables) == len({row.key for row in rows})


def test_markdown_has_every_method_that_was_run_and_a_row_for_every_verdict(folder: Path) -> None:
    text = plain((folder / "scenes" / "made-up-top.md").read_text(encoding="utf-8"))
    for row in results().rows:
        if row.key.scenario == "made-up-top":
            assert plain(f"{row.key.engine} {row.key.method} {row.engine_version} · ") in text
    for verdict in VERDICTS:
        tables = markdown_tables(folder / "scenes" / f"{verdict.key.scenario}.md")
        rows = [plain("|".join(row)) for table in tables for row in table[2:]]
        assert any(
            row.startswith(f"{verdict.key.engine}|{verdict.key.method}|")
            and verdict.verdict in row
            and verdict.reason in row
            for row in rows
        )


def test_markdown_s_tables_are_rectangular_and_its_links_lead_to_files(folder: Path) -> None:
    for path in folder.rglob("*.md"):
        for table in markdown_tables(path):
            assert len({len(row) for row in table}) == 1, table
        targets = re.findall(r"(?<!\\)\]\(([^)]+)\)", outside_code(path))
        assert targets
        for target in targets:
            assert (path.parent / unquote(target)).is_file(), target


def test_a_window_cut_by_chaos_and_the_code_s_own_numbers_are_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("spincheck.reports.harness.timesteps.ladder.MAX_STEPS", 7654321)
    stored = results()
    top = stored.scenes["made-up-top"]
    chaotic = SceneResult(top.scenario, replace(top.solution, horizon=1.234))
    render(replace(stored, scenes=stored.scenes | {"made-up-top": chaotic}), tmp_path)
    for suffix in ("html", "md"):
        text = (tmp_path / "scenes" / f"made-up-top.{suffix}").read_text(encoding="utf-8")
        assert "chaotic" in text
        assert "1.23" in text
    brick = (tmp_path / "scenes" / "made-up-brick.html").read_text(encoding="utf-8")
    assert "chaotic" not in brick
    for name in ("index.html", "report.md"):
        text = (tmp_path / name).read_text(encoding="utf-8")
        assert "7\N{NARROW NO-BREAK SPACE}654\N{NARROW NO-BREAK SPACE}321" in text


def test_the_same_results_give_the_same_bytes(folder: Path, tmp_path: Path) -> None:
    new = tmp_path / "new"
    assert render(results(), new) == new / "index.html"
    first = {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
    assert first == {p.relative_to(new): p.read_bytes() for p in new.rglob("*") if p.is_file()}


def test_pages_stay_light_with_many_samples_and_methods(tmp_path: Path) -> None:
    many = [MadeUp("elsewhere", f"method {k}", 1 + k % 4) for k in range(12)]
    render(results(samples=2001, methods=many), tmp_path)
    assert max(path.stat().st_size for path in tmp_path.rglob("*.html")) < HEAVIEST_PAGE


def test_verdicts_can_be_read_on_their_grounds() -> None:
    style = source("style.css")
    for theme in (style[: style.index("@media")], style[style.index("@media") :]):
        for verdict in {v.verdict for v in VERDICTS}:
            ground, text = (
                re.search(rf"--{kind}{verdict}: (#\w{{6}})", theme) for kind in ("", "on-")
            )
            assert ground is not None
            assert text is not None
            assert contrast(ground[1], text[1]) >= AA, verdict


def _errors_too_small(page: Page) -> list[str]:
    """Printed errors below the uncertainty in the tables of runs."""
    tables = [table for table in page.tables() if "steps" in table[0]]
    columns = {tables[0][0].index(SIGNAL[name].error_title): limit for name, limit in UNCERTAINTY}
    return [
        row[column]
        for runs in tables
        for row in runs[1:]
        for column, limit in columns.items()
        # Printing rounds to three digits.
        if row[column] != "—" and _value(row[column]) < limit * (1 - 5e-3)
    ]


def _value(text: str) -> float:
    """A printed number as a number."""
    plain = text.removeprefix("≤ ").translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-"))
    return float(plain.replace("×10", "e"))


def test_what_engines_do_as_shipped_is_distinguished() -> None:
    stored = results()
    verdicts = [replace(v, as_shipped=True) for v in stored.verdicts if v.verdict == "disagrees"]
    assert verdicts
    gathered = report_data(replace(stored, verdicts=verdicts))
    assert complaints(gathered, lambda kind: kind.fails).rows == ()
    assert len(complaints(gathered, lambda kind: kind.fails, as_shipped=True).rows) == len(verdicts)
    assert f"0 of {len(verdicts)} pairs converge" in headline(gathered)
