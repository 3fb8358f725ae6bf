#!/usr/bin/env python3
"""check_functions.py SOURCE: the lists of functions of other engines in SOURCE/docs/data are sound, and every name of
psim in the lists and in the pages about these engines is in the headers of SOURCE/include/psim.

A row has a function of the other engine, the names of psim that take its place, separated by `; `, and a note. Without
such names the note begins with `not needed: ` or `missing`. Under the heading `## What is missing` a page names every
missing function; `*` stands for any letters."""
import csv
import fnmatch
import pathlib
import re
import sys

# The most rows that may be missing. Lower a figure whenever psim has learnt something.
MOST_MISSING = {"box2d": 4, "chipmunk": 45, "rapier2d": 25}
PAGES = {"box2d": "coming-from-box2d.md", "chipmunk": "coming-from-chipmunk.md"}
PREFIXES = {"box2d": "b2", "chipmunk": "cp"}
SCOPE = r"\b(?:enum\s+class|enum|class|struct|namespace)\s+(?:PSIM_API\s+)?(\w+)[^;{}()]*\{"


def words_of_headers(folder):
    """Every word of the headers, and the words inside of each class, struct, enumeration and namespace."""
    words, inside = set(), {}
    for path in sorted(folder.rglob("*.h")):
        text = re.sub(r"//.*|/\*(?s:.*?)\*/", "", path.read_text(encoding="utf-8"))
        words |= set(re.findall(r"\w+", text))
        for match in re.finditer(SCOPE, text):
            depth, end = 1, match.end()
            while depth and end < len(text):
                depth += {"{": 1, "}": -1}.get(text[end], 0)
                end += 1
            inside.setdefault(match[1], set()).update(re.findall(r"\w+", text[match.end():end]))
    return words, inside


def unknown(name, words, inside):
    scope, _, member = name.rpartition("::")
    return member not in inside.get(scope, ()) if scope else member not in words


def check_list(engine, path, words, inside):
    """Returns the faults of one list and its missing functions."""
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    if header != [engine, "psim", "note"]:
        return [f"{path.name}: the header is not {engine},psim,note"], []
    if any(len(row) != 3 for row in rows):
        return [f"{path.name}: a row has not three columns"], []
    faults, missing = [], []
    names = [row[0] for row in rows]
    for before, name in zip(names, names[1:]):
        if before >= name:
            faults.append(f"{path.name}: {name} stands after {before}: rows are sorted, each once")
    for name, ours, note in rows:
        named = ours.split("; ") if ours else []
        named += re.findall(r"\b[A-Z]\w*::\w+", note)
        faults += [f"{path.name}: {name}: {n} is not in include/psim" for n in named if unknown(n, words, inside)]
        if not ours and not note.startswith(("not needed: ", "missing")):
            faults.append(f"{path.name}: {name} has no name of psim, and its note no `not needed: ` or `missing`")
        if ours and note.startswith(("not needed", "missing")):
            faults.append(f"{path.name}: {name} has a name of psim, and its note says that there is none")
        if not ours and note.startswith("missing"):
            missing.append(name)
    if len(missing) > MOST_MISSING[engine]:
        faults.append(f"{path.name}: {len(missing)} functions are missing, MOST_MISSING allows {MOST_MISSING[engine]}")
    mapped = sum(bool(row[1]) for row in rows)
    print(f"{path.name}: {len(rows)} functions, {mapped} with names of psim, {len(missing)} missing")
    return faults, missing


def check_page(engine, path, names, missing, words, inside):
    """Returns the faults of a page: names of psim that do not exist, and an incomplete section on missing functions."""
    text = path.read_text(encoding="utf-8")
    faults = [f"{path.name}: {n} is not in include/psim" for n in sorted(set(re.findall(r"`([A-Z]\w*::\w+)`", text)))
              if unknown(n, words, inside)]
    section = text.partition("## What is missing\n")[2].partition("\n## ")[0]
    patterns = re.findall(rf"`({PREFIXES[engine]}[\w*]+)`", section)
    for pattern in patterns:
        found = fnmatch.filter(names, pattern)
        if not found:
            faults.append(f"{path.name}: no function is called {pattern}")
        faults += [f"{path.name}: {pattern} is no missing function: {n}" for n in found if n not in missing]
    faults += [f"{path.name}: {n} is missing and not named" for n in missing
               if not any(fnmatch.fnmatchcase(n, pattern) for pattern in patterns)]
    return faults


def main():
    source = pathlib.Path(sys.argv[1])
    words, inside = words_of_headers(source / "include/psim")
    faults = []
    for engine in MOST_MISSING:
        path = source / f"docs/data/{engine}-functions.csv"
        found, missing = check_list(engine, path, words, inside)
        faults += found
        if engine in PAGES:
            with path.open(newline="", encoding="utf-8") as file:
                names = [row[0] for row in csv.reader(file)][1:]
            faults += check_page(engine, source / "docs" / PAGES[engine], names, missing, words, inside)
    for fault in faults:
        print(fault)
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
