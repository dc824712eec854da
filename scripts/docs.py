#!/usr/bin/env python3
"""Checks the documentation: docs/SUMMARY.md lists every page once, every relative link resolves, tables have a header,
code fences are closed, and every page named in a source file exists."""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FENCE = re.compile(r"^(```|~~~).*?^\1", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\(<?([^)>\s]+)>?(?:\s+\"[^\"]*\")?\)")
NAMED = re.compile(r"\bdocs/[\w./-]+\.(?:md|svg|json|ipynb)\b")
SOURCES = {".rs", ".py", ".toml", ".h", ".hpp", ".cs", ".js", ".mjs", ".sh", ".html", ""}


def anchors(text: str) -> set[str]:
    """Returns the anchors of a page, as GitHub and mdBook make them."""
    found: set[str] = set()
    text = FENCE.sub("", text)
    for title in re.findall(r"^#{1,6} +(.+?) *#*$", text, re.MULTILINE):
        title = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", title)
        slug = re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
        number = 0
        while (name := f"{slug}-{number}" if number else slug) in found:
            number += 1
        found.add(name)
    return found | set(re.findall(r"""\bid="([^"]+)\"""", text))


def faults_of_form(text: str) -> list[str]:
    """Returns the tables without a header and the code fences that are not closed."""
    faults = []
    if len(re.findall(r"^ *```", text, re.MULTILINE)) % 2:
        faults.append("a code fence is not closed")
    for table in re.findall(r"(?:^\|.*\n)+", FENCE.sub("", text) + "\n", re.MULTILINE):
        lines = table.splitlines()
        if len(lines) < 2 or not re.fullmatch(r"\|(?: *:?-+:? *\|)+", lines[1]):
            faults.append(f"a table has no header: {lines[0][:60]}")
    return faults


def main() -> int:
    listed = subprocess.check_output(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, text=True)
    files = [ROOT / name for name in listed.splitlines()]
    files = [file for file in files if file.is_file()]
    errors: list[str] = []

    # The lists of third parties of the bindings are written for their packages.
    pages = {file: file.read_text() for file in files if file.suffix == ".md" and file.name != "THIRD-PARTY.md"}
    known = {file.resolve(): anchors(text) for file, text in pages.items()}
    for page, text in pages.items():
        errors += [f"{page.relative_to(ROOT)}: {fault}" for fault in faults_of_form(text)]
        for target in LINK.findall(re.sub(r"`[^`\n]*`", "", FENCE.sub("", text))):
            if re.match(r"[a-z]+:", target):
                continue
            path, _, anchor = target.partition("#")
            goal = (page.parent / path).resolve() if path else page.resolve()
            if not goal.exists():
                errors.append(f"{page.relative_to(ROOT)}: {target}: there is no such file")
            elif anchor and goal.suffix == ".md" and anchor not in known.get(goal, set()):
                errors.append(f"{page.relative_to(ROOT)}: {target}: there is no such heading")

    summary = ROOT / "docs/SUMMARY.md"
    chapters = [(summary.parent / target).resolve() for target in LINK.findall(summary.read_text())]
    for page in sorted(page.resolve() for page in pages if page.is_relative_to(summary.parent) and page != summary):
        if chapters.count(page) != 1:
            errors.append(f"docs/SUMMARY.md: {page.relative_to(ROOT)} is listed {chapters.count(page)} times")

    for file in files:
        if file.suffix in SOURCES and not file.is_symlink():
            try:
                text = file.read_text()
            except UnicodeDecodeError:
                continue
            for name in sorted(set(NAMED.findall(text))):
                if not (ROOT / name).exists():
                    errors.append(f"{file.relative_to(ROOT)}: {name}: there is no such file")

    for error in errors:
        print(error, file=sys.stderr)
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
