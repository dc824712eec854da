#!/usr/bin/env python3
"""Checks the documentation: docs/SUMMARY.md lists every page once, every relative link resolves, tables have a header,
code fences are closed, every page named in a source file exists, the reference has every key of a scene, device or
calibration file, and the README's results are those of docs/results. `scripts/reference --check` compares the flags,
reports and crates.

    scripts/docs.py            checks, and lists the faults
    scripts/docs.py --words    counts the words of each page of docs
"""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FENCE = re.compile(r"^(```|~~~).*?^\1", re.DOTALL | re.MULTILINE)
CODE = re.compile(r"^ *(```|~~~).*?^ *\1", re.DOTALL | re.MULTILINE)
MADE = re.compile(r"^<!-- .*?^<!-- end -->", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\(<?([^)>\s]+)>?(?:\s+\"[^\"]*\")?\)")
NAMED = re.compile(r"\bdocs/[\w./-]+\.(?:md|svg|json|ipynb)\b")
# Files that read the keys of scenes, linkages and calibrated devices, those of settings of methods, and their pages.
KEY_SOURCES = ["crates/palpate-scene/src", "crates/palpate-study/src/calibrate"]
SETTING_SOURCES = ["crates/palpate-core/src/render"]
KEY_PAGES = ["scene.md", "world-devices.md", "world-shapes.md", "device-file.md"]
# Pages that a command writes: `scripts/reference`, and `npm run gallery --prefix conformance/browser`.
GENERATED = {"docs/reference/flags.md", "docs/gallery.md"}
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


def words(text: str) -> int:
    """Returns the number of tokens with a letter or digit."""
    return len(re.findall(r"\S*\w\S*", text))


def print_words() -> None:
    """Prints the words of each page of docs by hand (prose, tables, code examples) and those that a command writes."""
    header = ("prose", "tables", "code", "generated")
    rows: list[tuple[list[int], str]] = []
    for page in sorted((ROOT / "docs").rglob("*.md")):
        text, name = page.read_text(), str(page.relative_to(ROOT))
        by_hand = "" if name in GENERATED else MADE.sub("", text)
        without_code = CODE.sub("", by_hand)
        prose = re.sub(r"^ *\|.*$", "", without_code, flags=re.MULTILINE)
        counts = [words(part) for part in (prose, without_code, by_hand, text)]
        rows.append(([after - before for before, after in zip([0, *counts], counts)], name))
    rows.sort(key=lambda row: -row[0][0])
    pages = list(rows)
    for title, part in [("outside docs/results", False), ("docs/results", True), ("all", None)]:
        of = [counts for counts, name in pages if part is None or name.startswith("docs/results/") == part]
        rows.append(([sum(column) for column in zip(*of)], title))
    print("".join(f"{title:>10}" for title in header))
    for counts, name in rows:
        print("".join(f"{count:10}" for count in counts) + f"  {name}")


def faults_of_readme() -> list[str]:
    """Returns the rows of the README's results that differ from those of docs/results/suite.md with more digits."""
    names = {"HFCR": "hfcr", "coupled, delay modelled": "coupled"}
    rows = {}
    for page in ("README.md", "docs/results/suite.md"):
        for line in re.findall(r"^\| .*\(.*\|$", (ROOT / page).read_text(), re.MULTILINE):
            name, *cells = [cell.strip() for cell in line.strip("|").split("|")]
            rows.setdefault((page, name), [float(cell.split()[0]) for cell in cells[:4] if re.match(r"[\d.]+ \(", cell)])
    faults = []
    for shown, name in names.items():
        found, expected = rows.get(("README.md", shown)), rows.get(("docs/results/suite.md", name))
        if not found or not expected or any(abs(a - b) > 0.51 for a, b in zip(found, expected, strict=True)):
            faults.append(f"README.md: {shown} is {found}, but docs/results/suite.md has {expected} for {name}")
    return faults


def faults_of_keys() -> list[str]:
    """Returns the keys of files that the reference lacks, and those in its tables that the sources lack."""
    code, settings = (
        "\n".join(file.read_text() for name in names for file in sorted((ROOT / name).rglob("*.rs")))
        for names in (KEY_SOURCES, SETTING_SOURCES)
    )
    keys: set[str] = set()
    for fields in re.findall(r"deny_unknown_fields[^{]*?struct \w+[^{;]*\{(.*?)\n\}", code, re.DOTALL):
        renamed = r"""(?:#\[serde\([^)]*?rename = "(\w+)"[^)]*\)\]\s+)?"""
        for new, name in re.findall(renamed + r"^ +(?:pub(?:\([^)]*\))? )?(?:r#)?([a-z]\w*):", fields, re.MULTILINE):
            keys.add(new or name)
    if len(keys) < 100:
        return [f"{KEY_SOURCES[0]}: only {len(keys)} keys were found; scripts/docs.py no longer reads the structs"]
    pages = {name: (ROOT / "docs/reference" / name).read_text() for name in KEY_PAGES}
    text = "\n".join(pages.values())
    faults = [f"docs/reference: the key {key} is missing" for key in sorted(keys) if not re.search(rf"\b{key}\b", text)]
    for name, page in pages.items():
        for cell in re.findall(r"^\| (.*?) \|", page, re.MULTILINE):
            for key in re.findall(r"`\.?(?:[\w.-]+\.)?([a-z_0-9]+)`", cell):
                if not re.search(rf"\b{key}\b", code + settings, re.IGNORECASE):
                    faults.append(f"docs/reference/{name}: the sources have no key {key}")
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

    errors += faults_of_keys() + faults_of_readme()
    for error in errors:
        print(error, file=sys.stderr)
    return 1 if errors else 0


if __name__ == "__main__":
    if sys.argv[1:] == ["--words"]:
        print_words()
    else:
        sys.exit(main())
