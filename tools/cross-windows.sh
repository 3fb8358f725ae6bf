# shellcheck shell=bash disable=SC2154
# x86-64 Windows, for tools/cross; to be sourced after tools/setup.sh. mingw-w64 builds, Wine runs.

psim_windows_packages=(g++-mingw-w64-x86-64-posix libz-mingw-w64-dev wine wine64 cmake ninja-build libcli11-dev
                       nlohmann-json3-dev libfmt-dev googletest python3)

# A Windows of its own under build/, without a screen.
as_windows=(env -u DISPLAY "WINEPREFIX=$psim_root/build/windows/wine" WINEDEBUG=-all "WINEDLLOVERRIDES=mscoree,mshtml=")

# Made before two programs do so at once, which leaves half of it.
windows_prepare() { psim_quietly "wineboot" timeout 300 "$@" wineboot --init; }

windows_wine() { command -v wine64 || echo wine; }

# What only POSIX has: devices, links, limits of memory. Wine sends Ctrl-Break to no process without a console:
# windows_ctrl_c has one.
windows_without=(CliFiles.AnOldFileIsReplacedAndALinkFollowed CliFiles.DevicesAreWrittenStraight
                 CliFiles.TwoOptionsCannotShareAFile
                 CliOptions.TooManyBodiesForTheMemoryAreNamedWithTheBytesNeeded CliReplay.OneLineSaysWhatIsWrong
                 CliReplay.AnInterruptedReplayHasNotComparedAll CliReport.CtrlCEndsTheRunAndStillReports)

# The C API of the DLL, from strict C99. windows_dll COMMAND...: by which programs run.
windows_dll() {
  local dir="$psim_root/build/windows"
  x86_64-w64-mingw32-gcc-posix -std=c99 -pedantic -Wall -Wextra -Werror -I "$psim_root/include" \
    "$psim_root"/tests/capi/c99.c "$psim_root"/tests/capi/abi_v1*.c -o "$dir/c99_dll.exe" "$dir/libpsim_dll.dll.a" || return 1
  "$@" "$dir/c99_dll.exe"
}

# Ctrl-C in a console.
windows_ctrl_c() {
  rm -f "$psim_root/build/windows/ctrl-c.csv"
  "${as_windows[@]}" python3 "$psim_root/tests/program/console_windows.py" "$(windows_wine)" \
    "$psim_root/build/windows/psim.exe" build/windows/ctrl-c.csv
}

# cross_windows [--quick]: the quick suite under Wine, the DLL, golden hashes, Ctrl-C, states that travel. With --quick
# the worker pool and a few golden hashes alone.
cross_windows() {
  local isa threads scene wine targets=(psim golden psim_pool_tests)
  [[ ${1:-} == --quick ]] || targets+=(psim_shared psim_tests psim_c99)
  psim_install "${psim_windows_packages[@]}" "${psim_packages[@]}" || return 1
  wine=("${as_windows[@]}" "$(windows_wine)")
  psim_build release psim || return 1  # Linux, to compare with
  psim_build windows "${targets[@]}" || return 1
  windows_prepare "${wine[@]}" || return 1
  cd "$psim_root" || return 1  # tests read scenes/ and docs/: Wine's drive Z: is this machine's root
  local golden=("${wine[@]}" build/windows/golden.exe check tests/golden/small.csv)
  if [[ ${1:-} == --quick ]]; then
    for scene in rain card_house joint_grid; do
      cross_check "golden hashes of $scene" "${golden[@]}" --scene "$scene" --threads 2
    done
  else
    psim_say "running the tests under Wine"
    cross_suite "-$(IFS=:; echo "Slow*:*/Slow*:Stress*:${windows_without[*]}")" "${wine[@]}" build/windows/psim_tests.exe
    cross_check "the C API in C99" "${wine[@]}" build/windows/psim_c99.exe
    cross_check "the C API of the DLL" windows_dll "${wine[@]}"
    for isa in scalar sse avx2; do
      for threads in 1 2 3; do
        cross_check "golden hashes, $isa, $threads threads" "${golden[@]}" --isa "$isa" --threads "$threads"
      done
    done
    cross_check "Ctrl-C in a console" windows_ctrl_c
  fi
  cross_suite "*" "${wine[@]}" build/windows/psim_pool_tests.exe
  cross_check "states and recordings travel" cross_states_travel "${wine[@]}" build/windows/psim.exe
  cross_result
}
