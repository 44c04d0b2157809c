"""Pages as Markdown: the words of a page, its tables and its code, and nothing that is drawn."""

from spincheck.reports.pages.markdown import as_markdown

PAGE = """<head><title>not a word</title></head>
<nav><a href="../index.html#here">report</a> › one</nav>
<h2>What <em>is</em> it?</h2>
<p data-drawn>not a word</p>
<p>It spins at 4\u202f096 <code>rad_s</code>, <a href="two.html#x">faster</a>
  than a_b<svg><path>not a word</path></svg></p>
<ul><li>one</li><li><strong>two</strong></li></ul>
<dl><dt>mass</dt><dd>1 kg</dd></dl>
<pre><code>a  |
b</code></pre>
<table>
<thead><tr><th></th><th>RK4</th><th>Euler</th></tr></thead>
<tbody><tr><td>top</td>
<td>1<span class="detail">stock</span></td>
<td>a|b<details class="note">not a word</details></td></tr>
</tbody></table>
<details><summary>More</summary><div data-table="0"></div></details>"""
ITEMS = [
    {
        "headings": ["scene", "error"],
        "rows": [[["top", "", "", "top.html"], ["1", "number", "stock"]]],
    }
]
MARKDOWN = """[report](../report.md) › one

## What *is* it?

It spins at 4\u202f096 `rad_s`, [faster](two.md) than a\\_b

- one
- **two**

- mass: 1 kg

```
a  |
b
```

|  | RK4 | Euler |
| --- | --- | --- |
| top | 1 (stock) | a\\|b |

More

| scene | error |
| --- | --- |
| [top](top.md) | 1 (stock) |
"""


def test_a_page_is_its_words_tables_and_code() -> None:
    assert as_markdown(PAGE, ITEMS) == MARKDOWN
