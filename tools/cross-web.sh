# shellcheck shell=bash
# WebAssembly, for tools/cross and tools/web; to be sourced after tools/setup.sh.
# cross_web builds build/web: psim.mjs (Node), index.html (a page) and npm/ (the package), and runs their tests.

psim_web_packages=(emscripten nodejs cmake ninja-build libcli11-dev nlohmann-json3-dev libfmt-dev googletest bzip2
                   python3)

export NODE_PATH=/usr/share/nodejs  # where Debian's emscripten has its acorn; other builds of node do not look there

# zlib's source, of the version that the native library of the same system has, so that pictures have the same bytes.
psim_fetch_zlib() {
  local folder="$psim_root/build/packages/zlib" work file
  [[ -f $folder/deflate.c ]] && return 0
  psim_say "fetching the source of zlib"
  work="$(mktemp -d)"
  chmod 755 "$work"
  (
    # shellcheck disable=SC1091
    source /etc/os-release
    mkdir -p "$work/lists/partial"
    echo "deb-src http://deb.debian.org/debian ${VERSION_CODENAME:-bookworm} main" >"$work/sources.list"
    cd "$work" || exit 1
    apt=(apt-get -qq -o "Dir::Etc::sourcelist=$work/sources.list" -o Dir::Etc::sourceparts=-
         -o "Dir::State::lists=$work/lists" -o Acquire::Retries=3)
    "${apt[@]}" update && "${apt[@]}" --download-only source zlib
  ) >"$work/log" 2>&1 || { cat "$work/log" >&2; psim_say "the source of zlib could not be fetched"; return 1; }
  mkdir -p "$folder"
  file="$(ls "$work"/zlib_*.orig.tar.*)"
  tar xf "$file" -C "$folder" --strip-components=1 || return 1
  rm -rf "$work"
}

# The page, the package and the program in one folder, from both builds.
psim_web_gather() {
  local out="$psim_root/build/web" threads="$psim_root/build/web-threads"
  mkdir -p "$out/npm/wasm" "$out/page"
  cp "$psim_root"/web/{psim.mjs,serve.mjs,index.html} "$out"
  cp "$psim_root"/web/page/* "$out/page"
  cp "$psim_root"/packaging/npm/* "$psim_root/LICENSE" "$out/npm"
  cp "$out"/psim-{simd,plain}.{mjs,wasm} "$out/npm/wasm"
  cp "$threads"/psim-simd-threads.{mjs,wasm,worker.js} "$out/npm/wasm"
  cp "$threads"/program-threads.{js,wasm,worker.js} "$out"
}

psim_web_build() {
  psim_install "${psim_web_packages[@]}" || return 1
  psim_fetch_zlib || return 1
  psim_build web psim psim-simd psim-plain || return 1
  psim_build web-threads psim psim-simd "$@" || return 1
  psim_web_gather
}

cross_web() {
  psim_web_build golden psim_tests || return 1
  local threads passed=0 failed=0 log tap
  threads="$psim_root/build/web-threads"
  local node=(node --no-experimental-fetch)  # by which emscripten's older code would look for files
  log="$(mktemp)"

  psim_say "golden hashes in Node, on both instruction sets"
  local isa
  for isa in scalar simd128; do
    if "${node[@]}" "$threads/golden.js" check "$psim_root/tests/golden/small.csv" --isa "$isa" --threads 2 >"$log" 2>&1
    then passed=$((passed + 1)); else failed=$((failed + 1)); cut -c1-300 "$log" | tail -20 >&2; fi
  done

  psim_say "psim_tests in Node"
  "${node[@]}" "$threads/psim_tests.js" --gtest_brief=1 --gtest_filter='-Slow*:*/Slow*:Stress*' >"$log" 2>&1
  passed=$((passed + $(sed -n 's/.*PASSED.* \([0-9]*\) tests\?\..*/\1/p' "$log" | tail -1)))
  tap=$(sed -n 's/.*FAILED.* \([0-9]*\) tests\?, listed.*/\1/p' "$log" | tail -1)
  grep -q 'PASSED' "$log" || tap=$((${tap:-0} + 1))
  ((${tap:-0})) && cut -c1-300 "$log" | tail -40 >&2
  failed=$((failed + ${tap:-0}))

  psim_say "the package, the program and the page"
  node --test --test-reporter=tap "$psim_root"/tests/web/ >"$log" 2>&1
  passed=$((passed + $(sed -n 's/^# pass \([0-9]*\)/\1/p' "$log" | tail -1)))
  tap=$(sed -n 's/^# fail \([0-9]*\)/\1/p' "$log" | tail -1)
  ((${tap:-1})) && cut -c1-300 "$log" | tail -60 >&2
  failed=$((failed + ${tap:-1}))
  rm -f "$log"
  echo "$passed passed, $failed failed"
  ((failed == 0))
}
