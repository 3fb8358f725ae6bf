# shellcheck shell=bash
# shellcheck disable=SC2154  # psim_root comes from tools/setup.sh
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
    mkdir -p "$work/lists/partial"
    # From where apt has the library: `zlib1g | VERSION | ADDRESS SUITE/COMPONENT ARCHITECTURE Packages`.
    apt-cache madison zlib1g | awk '{ split($6, of, "/"); print "deb-src", $5, of[1], of[2] }' |
      sort -u >"$work/sources.list"
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
  mkdir -p "$out/npm/wasm" "$out/page" "$out/scenes"
  cp "$psim_root"/web/{psim.mjs,serve.mjs,index.html} "$out"
  cp "$psim_root"/web/page/* "$out/page"
  cp "$psim_root"/scenes/*.json "$out/scenes"
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

# psim_web_count LOG PASSED FAILED: adds what two patterns find in a log. Without a word of what passed, one failed.
psim_web_count() {
  local passed failed
  passed="$(sed -n "$2" "$1" | tail -n 1)" failed="$(sed -n "$3" "$1" | tail -n 1)"
  [[ -n $passed ]] || failed=$((${failed:-0} + 1))
  ((${failed:-0} == 0)) || cut -c1-300 "$1" | tail -n 60 >&2
  psim_web_passed=$((psim_web_passed + ${passed:-0})) psim_web_failed=$((psim_web_failed + ${failed:-0}))
}

# cross_web [--quick]: builds and tests. --quick leaves psim_tests out, and the golden hashes of scalar kernels.
cross_web() {
  local targets=(golden psim_tests) isas=(scalar simd128) isa log counts threads="$psim_root/build/web-threads"
  if [[ ${1:-} == --quick ]]; then targets=(golden) isas=(simd128); fi
  psim_web_build "${targets[@]}" || return 1
  local node=(node --no-experimental-fetch)  # by which emscripten's older code would look for files
  psim_web_passed=0 psim_web_failed=0
  log="$(mktemp)"
  for isa in "${isas[@]}"; do
    psim_say "golden hashes, $isa"
    "${node[@]}" "$threads/golden.js" check "$psim_root/tests/golden/small.csv" --isa "$isa" --threads 2 >"$log" 2>&1
    counts="$(awk '/ scenes, [0-9]+ differ$/ { print "golden", $1 - $3, $3 }' "$log")"
    echo "$counts" >>"$log"
    psim_web_count "$log" 's/^golden \([0-9]*\) .*/\1/p' 's/^golden [0-9]* \(.*\)/\1/p'
  done
  if [[ ${1:-} != --quick ]]; then
    psim_say "psim_tests"
    "${node[@]}" "$threads/psim_tests.js" --gtest_color=no --gtest_filter='-Slow*:*/Slow*:Stress*' >"$log" 2>&1
    psim_web_count "$log" 's/^\[  PASSED  \] \([0-9]*\) tests*\.$/\1/p' 's/^\[  FAILED  \] \([0-9]*\) tests*, listed.*/\1/p'
  fi
  psim_say "the package, the program and the page"
  timeout 900 node --test --test-reporter=tap "$psim_root"/tests/web/ >"$log" 2>&1
  psim_web_count "$log" 's/^# pass \([0-9]*\)/\1/p' 's/^# fail \([0-9]*\)/\1/p'
  rm -f "$log"
  echo "$psim_web_passed passed, $psim_web_failed failed"
  ((psim_web_failed == 0))
}
