# shellcheck shell=bash disable=SC2154
# aarch64 Linux, for tools/cross; to be sourced after tools/setup.sh. Debian's cross compiler builds, qemu runs.
# Libraries are Debian's own for arm64, which stand beside those of this machine (multiarch). The programs are static.

psim_arm64_tools=(g++-aarch64-linux-gnu qemu-user-static)
psim_arm64_libraries=(zlib1g-dev:arm64 libpng-dev:arm64 libfmt-dev:arm64 libgtest-dev:arm64)
psim_on_arm64=(qemu-aarch64-static -L /usr/aarch64-linux-gnu)

# What cannot be asked in an emulator: limits of memory hold for the emulator itself, a death test that starts its own
# program again would start it without the emulator, and whether a program waits for Ctrl-C is not seen, since the
# emulator catches all signals (there is a check below). And long runs, three quarters of the suite's time, which would
# be an hour there: what they find out depends on the bits of the scenes alone, and those are compared by hashes.
arm64_without=(CliOptions.TooManyBodiesForTheMemoryAreNamedWithTheBytesNeeded "WorkerPoolDeathTest.*"
               "CliReplay.AnInterrupted*" "CliReport.CtrlC*" "CliVideo.CtrlC*"
               "SavedState.OfADisc*" "SleepRest.*" "SleepDeterminism.*" "RenewalRandom.*" "RenewalShapes.*"
               "RigidDeterminism.*" "RigidSpeed*" "RigidLaws.*" "Substeps/*" "Net.*" "Floors.APlate*" "Gas.*" "Target.*"
               "SceneSchema.BothJudge*" "Mixtures/*" "Pieces/*" "SparseWorld.*" "MixedRadii.*" "LawFuzz.*" "WorldFuzz.*"
               "Soak.*" "RigidStack.*" "RigidChain.*" "HullSweep.*" "Impact.OfACloud*" "SavedDamage.TheState*"
               "Contacts.AreTheSame*" "Coverage.EveryPixel*" "Strips.ContactsOf*")

# apt's packages for arm64, asked for once.
arm64_packages() {
  local as_root=() package
  command -v dpkg >/dev/null || { psim_say "tools/cross arm64 needs Debian's packages"; return 1; }
  if ! dpkg --print-foreign-architectures | grep -qx arm64; then
    ((EUID == 0)) || as_root=(sudo)
    "${as_root[@]}" dpkg --add-architecture arm64 || return 1
    psim_quietly "apt-get update" "${as_root[@]}" apt-get -qq -o DPkg::Lock::Timeout=600 -o Acquire::Retries=3 update ||
      return 1
  fi
  for package in "${psim_arm64_libraries[@]}"; do
    if ! apt-cache show "$package" >/dev/null 2>&1; then
      psim_say "apt knows no $package: Ubuntu keeps arm64 on ports.ubuntu.com, which must be among apt's sources"
      return 1
    fi
  done
  psim_install "${psim_packages[@]}" "${psim_arm64_tools[@]}" "${psim_arm64_libraries[@]}"
}

# cross_arm64 [--quick]: the quick suite under qemu, golden hashes, machine code, states that travel. With --quick the
# worker pool and a few golden hashes alone.
cross_arm64() {
  local dir="$psim_root/build/arm64" scene
  local filter
  filter="-$(IFS=:; echo "Slow*:*/Slow*:Stress*:${arm64_without[*]}")"
  local golden=("${psim_on_arm64[@]}" "$dir/golden" check tests/golden/small.csv --threads 2)
  arm64_packages || return 1
  psim_build release psim || return 1  # to compare with
  cd "$psim_root" || return 1
  if [[ ${1:-} == --quick ]]; then
    psim_build arm64 psim golden psim_pool_tests || return 1
    for scene in rain card_house joint_grid; do
      cross_check "golden hashes of $scene" "${golden[@]}" --scene "$scene"
    done
  else
    psim_build arm64 psim psim_shared golden psim_tests psim_pool_tests psim_c99 || return 1
    psim_say "running the tests under qemu"
    cross_suite "$filter" "${psim_on_arm64[@]}" "$dir/psim_tests"
    cross_check "the C API in C99" "${psim_on_arm64[@]}" "$dir/psim_c99"
    cross_check "golden hashes" "${golden[@]}"
    cross_check "Ctrl-C" timeout --preserve-status -s INT 10 \
      "${psim_on_arm64[@]}" "$dir/psim" --particles 100 --frames 1000000000
    cross_check "machine code" tools/asm-inspect --build "$dir" --check
  fi
  cross_suite "$filter" "${psim_on_arm64[@]}" "$dir/psim_pool_tests"
  cross_check "states and recordings travel" cross_states_travel "${psim_on_arm64[@]}" "$dir/psim"
  cross_result
}
