# shellcheck shell=bash disable=SC2154
# This machine without one intrinsic (PSIM_PORTABLE), for tools/cross; to be sourced after tools/setup.sh.

# cross_portable [--quick]: the quick suite, golden hashes, states that travel. With --quick a few golden hashes alone.
cross_portable() {
  local dir="$psim_root/build/portable" scene
  local golden=("$dir/golden" check tests/golden/small.csv --threads 2)
  psim_install "${psim_packages[@]}" || return 1
  psim_build release psim || return 1  # to compare with
  cd "$psim_root" || return 1
  if [[ ${1:-} == --quick ]]; then
    psim_build portable psim golden || return 1
    for scene in rain card_house joint_grid; do
      cross_check "golden hashes of $scene" "${golden[@]}" --scene "$scene"
    done
  else
    psim_build portable psim golden psim_tests psim_pool_tests psim_c99 || return 1
    psim_say "running the tests"
    PSIM_SCALAR_CPU=1 cross_suite "-Slow*:*/Slow*:Stress*" "$dir/psim_tests"
    cross_suite "*" "$dir/psim_pool_tests"
    cross_check "the C API in C99" "$dir/psim_c99"
    cross_check "golden hashes" "${golden[@]}"
  fi
  cross_check "states and recordings travel" cross_states_travel "$dir/psim"
  cross_result
}
