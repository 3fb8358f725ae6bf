#!/usr/bin/env python3
"""check_symbols.py NM LIBRARY INCLUDE: the library shows what the headers mark PSIM_API: the functions of C, the
free functions and the members of the classes of C++, and nothing else. C reaches each function and each
member of World."""
import pathlib
import re
import subprocess
import sys

nm, library, include = sys.argv[1:]
shown = subprocess.run([nm, "-D", "-C", "--defined-only", library],
                       check=True, capture_output=True, text=True).stdout
shown = {line.split(" ", 2)[2] for line in shown.splitlines()}


def marked(paths):
    """Names of functions that are marked PSIM_API."""
    text = "\n".join(re.sub(r"//.*|^#.*", "", path.read_text(), flags=re.MULTILINE) for path in paths)
    return set(re.findall(r"PSIM_API\s[^();]*?(\w+)\(", text))


headers = pathlib.Path(include) / "psim"
c_names = marked(sorted((headers / "c").glob("*.h")))
cpp_names = marked(sorted(headers.glob("*.h")))
classes = {name for path in headers.glob("*.h")
           for name in re.findall(r"class PSIM_API (\w+)", path.read_text())}
wrong = [f"{name} is declared in C but not shown" for name in sorted(c_names - shown)]
unmarked = r"(?!PSIM_API|inline|static|using|typedef)[\w:<>,&*]+ [\w:<>,&* ]*\w+\(|class (?!PSIM_API)[^;]*$"
for path in sorted(headers.rglob("*.h")):
    for line in path.read_text().splitlines():
        if re.match(unmarked, line):
            wrong.append(f"{path.name} does not mark with PSIM_API: {line}")
for symbol in sorted(shown):
    name = re.sub(r"\[abi:\w+\]", "", symbol).split("(")[0]
    derived_from = re.fullmatch(r"(?:vtable|typeinfo|typeinfo name) for psim::(\w+)", name)
    scopes = name.split("::")
    public = (derived_from is not None and derived_from[1] in classes or
              len(scopes) == 1 and name in c_names or
              len(scopes) == 2 and scopes[0] == "psim" and scopes[1] in cpp_names or
              len(scopes) == 3 and scopes[0] == "psim" and scopes[1] in classes)
    if not public:
        wrong.append(f"{symbol} is shown but not public")
# Members whose C function has another name; none for those that C cannot or need not call.
renamed = {"World": None, "~World": "psim_world_destroy", "published": "psim_world_state",
           "desc": "psim_world_get_desc", "measure_costs": "psim_measure_costs",
           "pre_solve": None, "write_bytes": None, "read_bytes": None, "out_of_memory": None}  # the last is a code there
for symbol in sorted(shown):
    if symbol.startswith("psim::World::"):
        member = re.sub(r"\[abi:\w+\]", "", symbol).split("(")[0].removeprefix("psim::World::")
        c_name = renamed.get(member, "psim_world_" + member)
    elif re.match(r"psim::\w+\(", re.sub(r"\[abi:\w+\]", "", symbol)):
        function = re.sub(r"\[abi:\w+\]", "", symbol).split("(")[0].removeprefix("psim::")
        c_name = renamed.get(function, "psim_" + function)
    else:
        continue
    if c_name is not None and c_name not in c_names:
        wrong.append(f"{symbol} has no {c_name} in C")
for line in wrong:
    print(line)
print(f"{len(shown)} names shown, {len(c_names)} of them of the C API")
sys.exit(bool(wrong) or len(c_names) < 50)
