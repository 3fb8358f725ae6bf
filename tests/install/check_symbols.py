#!/usr/bin/env python3
"""check_symbols.py NM LIBRARY INCLUDE: the library shows the functions of the C headers, the members of
psim::World and the free functions that the C++ headers mark PSIM_API, and nothing else; and C reaches
each of the latter."""
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
wrong = [f"{name} is declared in C but not shown" for name in sorted(c_names - shown)]
for symbol in sorted(shown):
    name = re.sub(r"\[abi:\w+\]", "", symbol).split("(")[0]
    if not (name in c_names or name.startswith("psim::World::") or
            (name.startswith("psim::") and name.removeprefix("psim::") in cpp_names)):
        wrong.append(f"{symbol} is shown but not public")
    if "Impl" in symbol:
        wrong.append(f"{symbol} is internal")
# Members whose C function has another name; none for those that C cannot or need not call.
renamed = {"World": None, "~World": "psim_world_destroy", "published": "psim_world_state",
           "desc": "psim_world_get_desc", "measure_costs": "psim_measure_costs"}
for symbol in sorted(shown):
    if symbol.startswith("psim::World::"):
        member = re.sub(r"\[abi:\w+\]", "", symbol).split("(")[0].removeprefix("psim::World::")
        c_name = renamed.get(member, "psim_world_" + member)
    elif symbol.startswith("psim::"):
        c_name = "psim_" + symbol.split("(")[0].removeprefix("psim::")
    else:
        continue
    if c_name is not None and c_name not in c_names:
        wrong.append(f"{symbol} has no {c_name} in C")
for line in wrong:
    print(line)
print(f"{len(shown)} names shown, {len(c_names)} of them of the C API")
sys.exit(bool(wrong) or len(c_names) < 50)
