# shellcheck shell=bash
# What demo and test have in common: installing what is missing, and the build. To be sourced by
# bash with `set -euo pipefail`.

REPOSITORY="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
# Another python3 earlier on the path (pyenv, conda, a virtual environment) knows no ROS packages.
export PATH="/usr/bin:$PATH"
unset PYTHONHOME PYTHONPATH VIRTUAL_ENV

say() { printf '\n== %s\n' "$*"; }
die() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

# Installs the packages of dependencies.txt that are not there yet, if any; with `except_testing` not
# those of its last part.
install_dependencies() {
  local skipped=
  [ "${1:-}" != except_testing ] || skipped='/^# Testing/,$d; '
  local package missing=() as_root=()
  command -v dpkg-query apt-get > /dev/null ||
    die "this script installs with apt, as on Debian 12; elsewhere install what package.xml names (rosdep) and build by catkin_make"
  local installed
  installed="$(dpkg-query -W -f='${db:Status-Abbrev}${Package}\n' 2> /dev/null | sed -n 's/^ii *//p')"
  while read -r package; do
    grep -qxF "$package" <<< "$installed" || missing+=("$package")
  done < <(sed "$skipped/^#/d; /^\$/d" "$REPOSITORY/scripts/dependencies.txt")
  [ ${#missing[@]} -eq 0 ] && return

  say "Installing ${#missing[@]} packages: ${missing[*]}"
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo > /dev/null || die "these packages need root or sudo to be installed"
    as_root=(sudo)
  fi
  as_root+=(env DEBIAN_FRONTEND=noninteractive)
  "${as_root[@]}" apt-get update -qq
  # Older releases lack some, as Debian 11 has no Highway; cmake says what that means.
  local known lacking=()
  known="$(apt-cache policy "${missing[@]}" |
    awk '/^[^ ]/ {name = $1} /Candidate:/ && $2 != "(none)" {sub(":$", "", name); print name}')"
  for package in "${missing[@]}"; do
    grep -qxF "$package" <<< "$known" || lacking+=("$package")
  done
  [ ${#lacking[@]} -eq 0 ] || say "This release has no package ${lacking[*]}"
  [ -n "$known" ] || return 0
  mapfile -t missing <<< "$known"
  "${as_root[@]}" apt-get install -y -qq --no-install-recommends -o DPkg::Lock::Timeout=300 \
    "${missing[@]}" > "${TMPDIR:-/tmp}/predictive_stereo_apt.$$.log" 2>&1 || {
    tail -30 "${TMPDIR:-/tmp}/predictive_stereo_apt.$$.log" >&2
    die "apt-get install failed"
  }
  rm -f "${TMPDIR:-/tmp}/predictive_stereo_apt.$$.log"
}

# configure FOLDER [cmake options]: configures the build in this folder of the repository, with what
# proves the package.
configure() {
  local build="$REPOSITORY/$1" launcher=() strict=OFF
  shift
  # catkin remembers the python path of the tests at the first configuration: this must exist then.
  mkdir -p "$build/devel/lib/python3/dist-packages"
  # ccache does not store what uses precompiled headers.
  command -v ccache > /dev/null &&
    launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON)
  # With the compiler of Debian 12 there are no warnings; with others they are no reason to stop.
  [ "$(c++ -dumpversion)" = 12 ] && strict=ON
  cmake -S "$REPOSITORY" -B "$build" -DPYTHON_EXECUTABLE=/usr/bin/python3 \
    -DPython3_EXECUTABLE=/usr/bin/python3 -DWARNINGS_AS_ERRORS=$strict -DPREDICTIVE_STEREO_EVALUATION=ON \
    "${launcher[@]}" "$@" \
    > "$build/configure.log" 2>&1 || {
    tail -40 "$build/configure.log" >&2
    die "cmake failed: see $build/configure.log"
  }
}

# build FOLDER [targets]: builds; all that is installed if no targets are given.
build() {
  local folder="$1" jobs
  shift
  jobs="$(nproc)"
  # A compiler takes up to 1 GB: on small machines memory is the limit.
  local by_memory=$(($(awk '/MemAvailable/ {print $2}' /proc/meminfo) / 1000000))
  if [ "$by_memory" -lt "$jobs" ]; then jobs=$((by_memory > 0 ? by_memory : 1)); fi
  # So that ccache finds what another clone of this repository has compiled.
  export CCACHE_BASEDIR="${CCACHE_BASEDIR:-$REPOSITORY}"
  # What was built before is not worth a line.
  cmake --build "$REPOSITORY/$folder" -j "$jobs" ${1:+--target "$@"} |
    { grep -v 'Built target' || true; } && return
  # With one job the error comes last and alone, and a compiler that lacked memory gets through.
  echo "The build failed. Again, with one job:" >&2
  cmake --build "$REPOSITORY/$folder" ${1:+--target "$@"} > "$REPOSITORY/$folder/build.log" 2>&1 || {
    tail -40 "$REPOSITORY/$folder/build.log" >&2
    die "the build failed: see $REPOSITORY/$folder/build.log"
  }
}
