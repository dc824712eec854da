#!/usr/bin/env python3
"""Finds dependency cycles of the files of palpate-cli and of the folders of every crate, by their `use` lines.

    scripts/circles.py              exit code 1 if there is a cycle
    scripts/circles.py FOLDER...    cycles of the files in these folders

A file depends on the files that define the names that it uses. A re-exported name (`pub use`) counts for the file that
defines it, and the `pub use` lines of a `mod.rs` do not count. Tests are ignored. A folder of a crate depends on the
folders on which its files depend.
"""

import re
import sys
from pathlib import Path

TESTS = re.compile(r'#\[cfg\((?:all\()?test\b[^\n]*\n(?:#\[(?:path = "(\w+)\.rs"|[^\n]*)\]\n)*mod (\w+);')
CRATES = Path(__file__).parent.parent / "crates"
USE = re.compile(r"\b(pub(?:\([a-z]+\))? )?use ([^;]+);")


def modules(folder):
    """Returns the text of each file, by the path of its module."""
    found = {}
    for path in folder.rglob("*.rs"):
        parts = path.relative_to(folder).with_suffix("").parts
        if parts[-1] in ("mod", "lib"):
            parts = parts[:-1]
        text = re.sub(r"//.*", "", path.read_text())
        found[parts] = (path.name, re.split(r"#\[cfg\(test\)\]\s*mod tests\b", text)[0])
    found.pop(("main",), None)
    tests = {
        (module[:-1] if path else module) + (path or name,)
        for module, (_, text) in found.items()
        for path, name in TESTS.findall(text)
    }
    for module in tests:
        found = {path: file for path, file in found.items() if path[: len(module)] != module}
    return found


def expand(tree):
    """Returns the paths of a `use` tree, without aliases."""
    tree = tree.strip()
    if "{" not in tree:
        return [tree.split(" as ")[0].strip()]
    before, inside = tree[: tree.index("{")], tree[tree.index("{") + 1 : tree.rindex("}")]
    parts, depth = [""], 0
    for character in inside:
        depth += (character == "{") - (character == "}")
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return [path for part in parts if part.strip() for path in expand(before + part.strip())]


def absolute(known, module, path):
    """Returns a path from the root of the crate; None for a path of another crate."""
    names = path.split("::")
    if names[0] == "crate":
        return tuple(names[1:])
    if names[0] == "self":
        return module + tuple(names[1:])
    if names[0] == "super":
        while names and names[0] == "super":
            module, names = module[:-1], names[1:]
        return module + tuple(names)
    return module + tuple(names) if module + (names[0],) in known else None


def arrows(known):
    """Returns the dependencies of each module."""
    used, handed_on = {}, {}
    for module, (name, text) in known.items():
        used[module] = set()
        for public, tree in USE.findall(text):
            for path in filter(None, (absolute(known, module, path) for path in expand(tree))):
                if public:
                    handed_on[module, path[-1]] = path
                if not (public and name == "mod.rs"):
                    used[module].add(path)

    def origin(path, seen=()):
        for length in range(len(path), -1, -1):
            module = path[:length]
            if module in known:
                further = handed_on.get((module, path[length])) if length < len(path) else None
                return origin(further, (*seen, further)) if further and further not in seen else module
        return None

    return {module: {origin(path) for path in paths} - {module, (), None} for module, paths in used.items()}


def circles(depends):
    """Returns the sets of modules that depend on each other, directly or indirectly."""
    reached = {}
    for module in depends:
        reached[module], waiting = set(), [module]
        while waiting:
            for other in depends[waiting.pop()] - reached[module]:
                reached[module].add(other)
                waiting.append(other)
    return {frozenset(b for b in reached[a] if a in reached[b]) for a in depends if a in reached[a]}


def of_folders(depends):
    """Returns the dependencies of the folders of a crate."""
    folders = {module[:1] for module in depends if len(module) > 1}
    found = {folder: set() for folder in folders}
    for module, others in depends.items():
        if module[:1] in folders:
            found[module[:1]] |= {other[:1] for other in others} & folders - {module[:1]}
    return found


def main():
    crates = sorted(CRATES.glob("*/src"))
    searched = [(Path(folder), lambda depends: depends) for folder in sys.argv[1:]]
    searched = searched or [(CRATES / "palpate-cli/src", lambda depends: depends)] + [(crate, of_folders) for crate in crates]
    are_there = False
    for folder, of in searched:
        for circle in sorted(circles(of(arrows(modules(folder)))), key=sorted):
            are_there = True
            print(f"{folder}: " + ", ".join(sorted("::".join(module) for module in circle)))
    return int(are_there)


if __name__ == "__main__":
    sys.exit(main())
