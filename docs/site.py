"""Builds the site. `docs/build` calls it with the folder to write.

The pages lie in docs/ and at the root of the repository, and link to files of both as they do there. Here each page is copied into one
folder, and its links follow: to pages, to copied pictures, and for everything else to the repository.
"""

import html.parser
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from urllib.parse import unquote

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
REPOSITORY = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["repository"]
PICTURES = {".png", ".svg"}
LINK = re.compile(r"(\]\()([^()\s#]*)(#[^()\s]*)?\)")
FENCE = re.compile(r"(?ms)^(```+).*?^\1\s*$|`[^`\n]+`")


def contents() -> list[tuple[str, dict[Path, str]]]:
    """The chapters of docs/index.md with their pages, and the title of each."""
    chapters = []
    for chapter in re.split(r"(?m)^## ", (DOCS / "index.md").read_text())[1:]:
        links = re.findall(r"(?m)^- \[(.*?)\]\((.*?)\)", chapter)
        pages = {(DOCS / link).resolve(): title for title, link in links}
        chapters.append((chapter.splitlines()[0], pages))
    return chapters


def name(page: Path) -> str:
    """The name of a page in the site."""
    if page == ROOT / "README.md":
        return "start"
    if page.parent in (DOCS, ROOT):
        return page.stem.lower()
    return page.parent.name.lower()


def followed(page: Path, text: str, names: dict[Path, str], stage: Path) -> str:
    """The text with links as the site needs them."""

    def follow(link: re.Match[str]) -> str:
        address, anchor = link[2], link[3] or ""
        if not address or re.match(r"[a-z]+:", address):
            return link[0]
        target = (page.parent / unquote(address)).resolve()
        if target in names:
            address = names[target] + ".md"
        elif not target.exists():
            sys.exit(f"{page.relative_to(ROOT)}: {address} is not there")
        else:
            path = target.relative_to(ROOT)
            if target.suffix in PICTURES:
                address = str(path.relative_to("docs"))
                (stage / address).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(target, stage / address)
            else:
                address = f"{REPOSITORY}/{'tree' if target.is_dir() else 'blob'}/main/{path}"
                address = address.removesuffix("/tree/main/.")
        return f"{link[1]}{address}{anchor})"

    parts, end = [], 0
    for code in FENCE.finditer(text):
        parts += [LINK.sub(follow, text[end : code.start()]), code[0]]
        end = code.end()
    return "".join(parts) + LINK.sub(follow, text[end:])


def staged(stage: Path) -> None:
    """Writes the pages into a folder."""
    chapters = contents()
    names = {page: name(page) for _, pages in chapters for page in pages}
    if len(set(names.values())) < len(names):
        sys.exit(f"two pages have one name: {sorted(names.values())}")
    names[DOCS / "index.md"] = "index"
    if forgotten := set(DOCS.glob("*.md")) - set(names):
        sys.exit(
            f"docs/index.md has no link to {', '.join(page.name for page in sorted(forgotten))}"
        )
    for page, own in names.items():
        text = followed(page, page.read_text(), names, stage)
        if own == "index":
            for chapter, pages in chapters:
                listed = "\n".join(f"{title} <{names[to]}>" for to, title in pages.items())
                text += f"\n```{{toctree}}\n:hidden:\n:caption: {chapter}\n\n{listed}\n```\n"
        (stage / f"{own}.md").write_text(text)


class Links(html.parser.HTMLParser):
    """The links and the anchors of a page."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(path.read_text())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for key, value in attrs:
            if key in ("href", "src") and value:
                self.links.append(value)
            elif key == "id" and value:
                self.anchors.add(value)


def broken(site: Path) -> tuple[int, int, list[str]]:
    """How many pages the site has, how many links inside of it, and those that lead nowhere."""
    pages = {path: Links(path) for path in sorted(site.rglob("*.html"))}
    count, found = 0, []
    for path, page in pages.items():
        for link in page.links:
            address, _, anchor = link.partition("#")
            if re.match(r"[a-z]+:", link):
                continue
            count += 1
            target = (
                Path(os.path.normpath(path.parent / unquote(address.split("?")[0])))
                if address
                else path
            )
            if not target.exists() or (
                anchor and target in pages and unquote(anchor) not in pages[target].anchors
            ):
                found.append(f"{path.relative_to(site)}: {link}")
    return len(pages), count, found


def main() -> None:
    site = Path(sys.argv[1])
    shutil.rmtree(site, ignore_errors=True)
    with tempfile.TemporaryDirectory() as folder:
        stage = Path(folder)
        staged(stage)
        # Warnings are errors: a link to an anchor that is not there, or a name in the package's documentation that is none.
        command = [
            sys.executable,
            "-m",
            "sphinx",
            "-q",
            "-W",
            "--keep-going",
            "-j",
            "auto",
            "-d",
            stage / ".read",
            "-c",
            DOCS,
        ]
        if subprocess.run([*command, stage, site]).returncode:
            sys.exit(1)
    pages, links, nowhere = broken(site)
    print(f"{site}: {pages} pages, {links} links inside of the site, {len(nowhere)} broken")
    if nowhere:
        sys.exit("\n".join(nowhere))


if __name__ == "__main__":
    main()
