#!/usr/bin/env python3
"""check_snippets.py SOURCE COMPILER...: the C++ and C code in README.md and the pages of SOURCE/docs compiles without
a warning. A block with `main` is a whole program; any other is the body of a function that has the names of AROUND.
Compilers with ++ in their names are those of C++. One that is not there is left out, but there must be one of each
language."""
import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess
import sys

WARNINGS = ["-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion", "-Wshadow", "-pedantic", "-Werror"]
# What a fragment makes serves code that is not shown, and it may make what others are given.
OF_FRAGMENTS = ["-Wno-unused-variable", "-Wno-unused-but-set-variable", "-Wno-shadow"]
# Code of the engine itself, which the engine's own tests compile.
INTERNAL = {"docs/kernels.md"}
# The other engine's half of a comparison, a header for a profiler.
FOREIGN = re.compile(r"\bb2\w+\(|\btracy::")

AROUND = {
    "cpp": ("""
#include <psim/psim.h>
#include <psim/mover.h>
#include <cstddef>
#include <memory>
#include <string>
{using}
void use(psim::BodyId);
void use(psim::BodyId, psim::Vec2, psim::Vec2);
void spark(psim::Vec2, psim::Vec2);
void play_sound(psim::Vec2, double);
bool has_key(psim::BodyId);
void draw(const psim::ShapePart&);
void push_out(psim::Vec2, double);
struct Game {{
  psim::WorldDesc desc;
  double dt = 1.0 / 60, due_s = 0, frame_s = 0, stick = 0;
  bool jump = false;
  psim::BodyId id;
  std::unique_ptr<psim::World> world;
  void frame();
}};
void Game::frame() {{
#line {line} "{page}"
{code}}}
""", "c++", "c++20"),
    "c": ("""
#include <psim.h>
void frame(psim_world* world);
void frame(psim_world* world) {{
#line {line} "{page}"
{code}}}
""", "c", "c99")}


def blocks(source):
    """Page, first line, language and code of each block in C++ or C."""
    for path in [source / "README.md", *sorted((source / "docs").glob("*.md"))]:
        page = str(path.relative_to(source))
        text = path.read_text(encoding="utf-8")
        for match in re.finditer(r"^```(cpp|c)\n(.*?)^```$", text, re.M | re.S):
            line = text.count("\n", 0, match.start(2)) + 1
            if page not in INTERNAL and not FOREIGN.search(match[2]):
                yield page, line, match[1], match[2]


def unit(page, line, language, code):
    """What the compiler is given."""
    if re.search(r"\bint main\(", code):
        return f'#line {line} "{page}"\n{code}', []
    # Pages of the library itself leave out `psim::`.
    using = "" if "psim::" in code else "using namespace psim;"
    return AROUND[language][0].format(using=using, page=page, line=line, code=code), OF_FRAGMENTS


def complaint(job):
    compiler, page, line, language, code = job
    text, more = unit(page, line, language, code)
    _, name, standard = AROUND[language]
    command = [compiler, "-x", name, f"-std={standard}", "-fsyntax-only", "-I", include, *WARNINGS, *more, "-"]
    result = subprocess.run(command, input=text, capture_output=True, text=True)
    return "" if result.returncode == 0 else f"{' '.join(command)}\n{result.stderr}"


root, *compilers = sys.argv[1:]
source = pathlib.Path(root)
include = str(source / "include")
found = list(blocks(source))
jobs, seen = [], set()
for compiler in compilers:
    path = shutil.which(compiler)
    if path is None:
        continue
    language = "cpp" if "++" in os.path.basename(path) else "c"
    if (os.path.realpath(path), language) in seen:
        continue
    seen.add((os.path.realpath(path), language))
    jobs += [(path, *block) for block in found if block[2] == language]
languages = {job[3] for job in jobs}
if languages != {"cpp", "c"} or len(found) < 8:
    sys.exit(f"nothing to check: {len(found)} blocks of code, languages {languages}")
with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
    complaints = [text for text in pool.map(complaint, jobs) if text]
print("\n".join(complaints))
print(f"{len(found)} blocks of code, compiled {len(jobs)} times, {len(complaints)} with a complaint")
sys.exit(bool(complaints))
