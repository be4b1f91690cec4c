"""The code of the documentation runs, page by page.

Blocks that begin with `>>>` are doctests; all others are executed. Blocks of a page share their
names, and files are written to a folder of the test.
"""

import doctest
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import LEFT, ROOT

PAGES = ["docs/python.md", "docs/coming-from.md", "README.md", "python/README.md"]


def blocks(page: Path) -> Iterator[tuple[int, str]]:
    """Line number and text of each block of Python."""
    text = page.read_text(encoding="utf-8")
    for found in re.finditer(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        yield text.count("\n", 0, found.start(1)), found[1]


@pytest.mark.parametrize("name", PAGES)
def test_the_code_of_a_page_runs(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    page = ROOT / name
    found = list(blocks(page))
    assert found, f"{name} has code"
    names: dict[str, object] = {"__name__": "page"}
    lacks = ""
    for line, text in found:
        if text.startswith(">>>"):
            test = doctest.DocTestParser().get_doctest(text, names, name, str(page), line)
            failed = doctest.DocTestRunner().run(test, clear_globs=False).failed
            names.update(test.globs)
            assert failed == 0, f"{name}:{line + 1}"
        else:
            # The empty lines let a traceback have the line of the page.
            try:
                exec(compile("\n" * line + text, str(page), "exec"), names)
            except (ImportError, ValueError) as error:
                # Where Rust has no target for WebAssembly, and where `tests/run` installs nothing for a view.
                is_left = "anywidget" in LEFT and "anywidget" in str(error)
                if is_left:
                    pytest.skip(f"the blocks before line {line + 1} ran: {error}")
                if "without the program of pages" not in str(error):
                    raise
                lacks = f"all blocks but the one of line {line + 1} ran: {error}"
    if lacks:
        pytest.skip(lacks)
