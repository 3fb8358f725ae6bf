#!/usr/bin/env python3
"""check_headers.py INCLUDE COMPILER...: each public header compiles alone, and no warning that a host may have on
comes from it: C++20 for all of them, C99 and C17 too for those of C. Compilers with ++ in their names are those of
C++. One that is not there is left out, but there must be one of each language."""
import concurrent.futures
import os
import pathlib
import shutil
import subprocess
import sys

WARNINGS = ["-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion", "-Wshadow", "-pedantic", "-Werror"]
WARNINGS_CPP = ["-Wnon-virtual-dtor", "-Woverloaded-virtual"]
WARNINGS_C = ["-Wstrict-prototypes"]

include, *compilers = sys.argv[1:]
headers = sorted(str(path.relative_to(include)) for path in pathlib.Path(include).rglob("*.h"))
c_headers = [name for name in headers if name == "psim.h" or name.startswith("psim/c/")]


def complaint(job):
    """What the compiler says to a file that includes the header alone, as a host's file: not as a system header."""
    compiler, language, standard, name = job
    command = [compiler, "-x", language, f"-std={standard}", "-fsyntax-only", "-I", include, *WARNINGS,
               *(WARNINGS_CPP if language == "c++" else WARNINGS_C), "-"]
    result = subprocess.run(command, input=f"#include <{name}>\n", capture_output=True, text=True)
    return "" if result.returncode == 0 else f"{' '.join(command)} <{name}>:\n{result.stderr}"


jobs, seen = [], set()
for compiler in compilers:
    path = shutil.which(compiler)
    if path is None:
        continue
    is_cpp = "++" in os.path.basename(path)
    if (os.path.realpath(path), is_cpp) in seen:
        continue
    seen.add((os.path.realpath(path), is_cpp))
    if is_cpp:
        jobs += [(path, "c++", "c++20", name) for name in headers]
    else:
        jobs += [(path, "c", standard, name) for standard in ("c99", "c17") for name in c_headers]
languages = {job[1] for job in jobs}
if languages != {"c", "c++"} or len(headers) < 20 or len(c_headers) < 5:
    sys.exit(f"nothing to check: {len(headers)} headers, languages {languages}")
with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
    complaints = [text for text in pool.map(complaint, jobs) if text]
print("\n".join(complaints))
print(f"{len(jobs)} files with one header each, {len(complaints)} with a warning")
sys.exit(bool(complaints))
