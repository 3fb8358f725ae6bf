# shellcheck shell=bash disable=SC2154
# x86-64 Windows, for tools/cross; to be sourced after tools/setup.sh. mingw-w64 builds, Wine runs.

psim_windows_packages=(g++-mingw-w64-x86-64-posix libz-mingw-w64-dev wine wine64 cmake ninja-build libcli11-dev
                       nlohmann-json3-dev libfmt-dev googletest python3)

# as_windows COMMAND...: with a Windows of its own under build/, without a screen.
as_windows() {
  env -u DISPLAY WINEPREFIX="$psim_root/build/windows/wine" WINEDEBUG=-all WINEDLLOVERRIDES="mscoree,mshtml=" "$@"
}

windows_wine() { command -v wine64 || echo wine; }

# on_windows PROGRAM ARGUMENTS...
on_windows() { as_windows "$(windows_wine)" "$@"; }

# What only POSIX has: devices, links, limits of memory. Wine sends Ctrl-Break to no process without a console:
# windows_ctrl_c has one.
windows_without=(CliFiles.AnOldFileIsReplacedAndALinkFollowed CliFiles.DevicesAreWrittenStraight
                 CliOptions.TooManyBodiesForTheMemoryAreNamedWithTheBytesNeeded CliReplay.OneLineSaysWhatIsWrong
                 CliReplay.AnInterruptedReplayHasNotComparedAll CliReport.CtrlCEndsTheRunAndStillReports)

windows_passed=0 windows_failed=0

# windows_check NAME COMMAND...: one test, by its exit status.
windows_check() {
  local name="$1" log
  shift
  log="$(mktemp)"
  if "$@" >"$log" 2>&1; then
    windows_passed=$((windows_passed + 1))
  else
    windows_failed=$((windows_failed + 1))
    tail -n 20 "$log"
    echo "failed: $name"
  fi
  rm -f "$log"
}

# windows_suite PROGRAM FILTER: a GoogleTest program, in two processes at once; every test counts. A process that dies
# is one failure more.
windows_suite() {
  local program="$1" filter="$2" folder shard passed failed
  folder="$(mktemp -d)"
  for shard in 0 1; do
    GTEST_TOTAL_SHARDS=2 GTEST_SHARD_INDEX="$shard" \
      on_windows "$program" --gtest_filter="$filter" --gtest_color=no >"$folder/$shard" 2>&1 &
  done
  wait
  for shard in 0 1; do
    passed="$(sed -n 's/^\[  PASSED  \] \([0-9]*\) test.*/\1/p' "$folder/$shard" | tail -n 1)"
    failed="$(grep -c '^\[  FAILED  \] .* ms)' "$folder/$shard")"
    if [[ -z $passed ]]; then
      tail -n 5 "$folder/$shard"
      echo "failed: $(basename "$program") did not come to its end"
      failed=$((failed + 1)) passed="$(grep -c '^\[       OK \]' "$folder/$shard")"
    fi
    if ((failed > 0)); then grep -B 12 '^\[  FAILED  \] .* ms)' "$folder/$shard"; fi
    windows_passed=$((windows_passed + passed)) windows_failed=$((windows_failed + failed))
  done
  rm -r "$folder"
}

# A saved state and a recording of Linux go on under Windows, and those of Windows on Linux, with the same bits.
windows_states_travel() {
  local folder here="$psim_root/build/release/psim" there="$psim_root/build/windows/psim.exe" status=0
  [[ -x $here ]] || { echo "build/release/psim is not built"; return 1; }
  folder="$(mktemp -d -p "$psim_root/build")"
  hash() { sed -n 's/.*"state_hash": *"\([^"]*\)".*/\1/p'; }
  local scene=(--scene rough-pile --particles 700 --report json)
  local whole half_here half_there
  whole="$("$here" "${scene[@]}" --frames 80 | hash)"
  "$here" "${scene[@]}" --frames 40 --save "$folder/here.psim" --record "$folder/here.rec" >/dev/null || status=1
  on_windows "$there" "${scene[@]}" --frames 40 --save "$folder/there.psim" --record "$folder/there.rec" >/dev/null ||
    status=1
  half_here="$(on_windows "$there" "${scene[@]}" --frames 40 --restore "$folder/here.psim" | hash)"
  half_there="$("$here" "${scene[@]}" --frames 40 --restore "$folder/there.psim" | hash)"
  on_windows "$there" --replay "$folder/here.rec" || status=1
  "$here" --replay "$folder/there.rec" || status=1
  cmp "$folder/here.psim" "$folder/there.psim" || status=1
  echo "80 frames at once $whole; saved on Linux $half_here; saved on Windows $half_there"
  [[ -n $whole && $whole == "$half_here" && $whole == "$half_there" ]] || status=1
  rm -r "$folder"
  return "$status"
}

# The C API of the DLL, from strict C99.
windows_dll() {
  local dir="$psim_root/build/windows"
  x86_64-w64-mingw32-gcc-posix -std=c99 -pedantic -Wall -Wextra -Werror -I "$psim_root/include" \
    "$psim_root"/tests/capi/{c99,abi_v1}.c -o "$dir/c99_dll.exe" "$dir/libpsim_dll.dll.a" || return 1
  on_windows "$dir/c99_dll.exe"
}

# Ctrl-C in a console.
windows_ctrl_c() {
  rm -f "$psim_root/build/windows/ctrl-c.csv"
  as_windows python3 "$psim_root/tests/program/console_windows.py" "$(windows_wine)" \
    "$psim_root/build/windows/psim.exe" build/windows/ctrl-c.csv
}

# cross_windows: installs, builds build/windows/psim.exe and the tests, runs them. The last line is
# `N passed, N failed`.
cross_windows() {
  local isa threads
  psim_install "${psim_windows_packages[@]}" "${psim_packages[@]}" || return 1
  psim_build windows psim psim_shared psim_tests psim_pool_tests psim_c99 golden || return 1
  psim_build release psim || return 1  # Linux, to compare with
  psim_say "running the tests under Wine"
  cd "$psim_root" || return 1  # tests read scenes/ and docs/: Wine's drive Z: is this machine's root
  windows_suite build/windows/psim_tests.exe "-$(IFS=:; echo "Slow*:*/Slow*:Stress*:${windows_without[*]}")"
  windows_suite build/windows/psim_pool_tests.exe "*"
  windows_check "the C API in C99" on_windows build/windows/psim_c99.exe
  windows_check "the C API of the DLL" windows_dll
  for isa in scalar sse avx2; do
    for threads in 1 2 3; do
      windows_check "golden hashes, $isa, $threads threads" \
        on_windows build/windows/golden.exe check tests/golden/small.csv --isa "$isa" --threads "$threads"
    done
  done
  windows_check "Ctrl-C in a console" windows_ctrl_c
  windows_check "states and recordings travel" windows_states_travel
  echo "$windows_passed passed, $windows_failed failed"
  ((windows_failed == 0 && windows_passed > 0))
}
