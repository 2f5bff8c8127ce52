"""Write the tables of buffers between their markers in docs/, from photonmap/buffers.py.

python tools/make_buffer_table.py
"""

from pathlib import Path

from photonmap.buffers import ADDED, RENDERED, as_markdown

DOCS = Path(__file__).parents[1] / "docs"

if __name__ == "__main__":
    for name, marker, rows in (
        ("guide.md", "buffers", RENDERED),
        ("dataset.md", "data set buffers", ADDED),
    ):
        begin, end = f"<!-- {marker} -->\n", f"\n<!-- /{marker} -->"
        text = (DOCS / name).read_text(encoding="utf-8")
        before, after = text.partition(begin)[0], text.partition(end)[2]
        table = begin + as_markdown(rows) + end
        (DOCS / name).write_text(before + table + after, encoding="utf-8")
