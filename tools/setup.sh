# shellcheck shell=bash disable=SC2034
# Shared by tools/run, tools/view, tools/test, tools/peers and .ci/run; to be sourced. Brings a bare Debian or
# Ubuntu to a configured and built psim. Talks to stderr only, and shows a log only when something
# failed.
# A second call finds everything in place and takes a fraction of a second.

psim_root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)"

psim_packages=(g++ cmake ninja-build libcpu-features-dev libgtest-dev libbenchmark-dev libcli11-dev
               nlohmann-json3-dev libfmt-dev zlib1g-dev libpng-dev binutils python3)
# What psim-view needs on top; libgl1-mesa-dri draws where there is no graphics card.
psim_view_packages=(libsdl2-dev libimgui-dev libgl1-mesa-dri)
# What tests use besides: a screen, films, generated docs, counted instructions, other processors, the layout.
psim_test_packages=(xvfb xauth ffmpeg doxygen valgrind qemu-user clang-format pkg-config)
# The engines that tools/peers compares with, and what draws the result.
psim_peers_packages=(libbox2d-dev libchipmunk-dev libbullet-dev libode-dev pkg-config
                     python3-matplotlib)

psim_say() { printf 'psim: %s\n' "$*" >&2; }

# psim_quietly WHAT COMMAND...: runs the command; its output appears on stderr if it fails.
psim_quietly() {
  local what="$1" log status=0
  shift
  log="$(mktemp)"
  "$@" >"$log" 2>&1 </dev/null || status=$?
  if ((status != 0)); then
    cat "$log" >&2
    psim_say "$what failed (exit $status); its output is above"
  fi
  rm -f "$log"
  return "$status"
}

# psim_install PACKAGE...: installs those that are missing; PACKAGE:ARCHITECTURE for another processor. Where there is no dpkg, CMake says what
# it does not find.
psim_install() {
  command -v dpkg-query >/dev/null || return 0
  local installed package missing=() as_root=()
  installed=" $(dpkg-query -W -f '${db:Status-Status}:${Package} ${db:Status-Status}:${Package}:${Architecture} ' \
    "$@" 2>/dev/null)"
  for package in "$@"; do
    [[ $installed == *" installed:$package "* ]] || missing+=("$package")
  done
  ((${#missing[@]})) || return 0

  if ((EUID != 0)); then
    if ! command -v sudo >/dev/null; then
      psim_say "missing packages; as root: apt-get install ${missing[*]}"
      return 1
    fi
    as_root=(sudo)
  fi
  psim_say "installing ${missing[*]}"
  psim_new_packages=1  # a build that was configured without them looks for them again
  local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get
             -o DPkg::Lock::Timeout=600 -y -qq)
  # With fresh package lists the first install succeeds; without any, or with stale ones, it
  # fails and an update comes first.
  "${apt[@]}" --no-install-recommends install "${missing[@]}" >/dev/null 2>&1 </dev/null && return 0
  psim_quietly "apt-get update" "${apt[@]}" -o Acquire::Retries=3 update || return 1
  psim_quietly "apt-get install" "${apt[@]}" -o Acquire::Retries=3 --no-install-recommends install "${missing[@]}"
}

# True if build/PRESET was configured from this very place and by these presets.
psim_is_configured() {
  local dir="$psim_root/build/$1"
  [[ -f $dir/build.ninja && -f $dir/CMakeCache.txt ]] || return 1
  [[ ! $psim_root/CMakePresets.json -nt $dir/build.ninja ]] || return 1
  grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$psim_root" "$dir/CMakeCache.txt"
}

# psim_build PRESET TARGET...: configures where needed, then builds. PSIM_CONFIGURE_ARGS may hold
# more options for CMake. Two calls at once wait for each other.
psim_build() {
  local preset="$1" dir
  shift
  dir="$psim_root/build/$preset"
  mkdir -p "$psim_root/build"
  (
    cd "$psim_root" || exit 1
    if command -v flock >/dev/null; then
      exec 9>"build/.lock"
      flock 9
    fi
    if [[ -n ${PSIM_CONFIGURE_ARGS:-}${psim_new_packages:-} ]] || ! psim_is_configured "$preset"; then
      if [[ -f $dir/CMakeCache.txt ]] &&
         ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$psim_root" "$dir/CMakeCache.txt"; then
        rm -rf "$dir"  # copied or moved from elsewhere: its paths point there
      fi
      [[ -f $dir/build.ninja ]] || psim_say "building $preset for the first time, a few minutes"
      # shellcheck disable=SC2086  # several options in one variable
      psim_quietly "cmake" cmake --preset "$preset" ${PSIM_CONFIGURE_ARGS:-} || exit 1
    fi
    psim_quietly "the $preset build" cmake --build "$dir" --target "$@" || exit 1
  )
}
