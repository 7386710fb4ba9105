#!/bin/sh
# Fills a folder with what a cross build for arm64 compiles and links against, from the Debian packages that the host's
# own sources offer. The host is left as it is: apt works on a state of its own, packages are unpacked and not installed.
#
#   toolchains/arm64_sysroot.sh [FOLDER]        (build/arm64-sysroot in the tree when it is not given)
#
# The compiler and the emulator are the host's, and are asked for: g++-aarch64-linux-gnu, qemu-user-static; and idlc, of
# cyclonedds-tools, which toolchains/setup.sh installs. A folder that is complete is left alone; delete it to renew it.
set -eu
sysroot=${1:-$(dirname "$0")/../build/arm64-sysroot}

for need in aarch64-linux-gnu-g++:g++-aarch64-linux-gnu qemu-aarch64-static:qemu-user-static idlc:cyclonedds-tools; do
  if ! command -v "${need%%:*}" >/dev/null; then
    echo "arm64_sysroot: ${need%%:*} is missing; as root, run: apt-get install --no-install-recommends ${need#*:}" >&2
    exit 1
  fi
done

# Libraries of what runs on a robot, with the C library below them. toolchains/setup.sh says what each is for.
packages="libc6-dev libstdc++-12-dev libeigen3-dev libexpected-dev libhwy-dev libccd-dev libboost-dev libtbb-dev
  libtomlplusplus-dev libcli11-dev nlohmann-json3-dev libpcap-dev liblzf-dev libxxhash-dev cyclonedds-dev
  libiceoryx-binding-c-dev libiceoryx-posh-dev libiceoryx-hoofs-dev libsqlite3-dev liboctomap-dev libopenvdb-dev
  libimath-dev doctest-dev"

mkdir -p "$sysroot"
sysroot=$(cd "$sysroot" && pwd)
if [ "$(cat "$sysroot/.complete" 2>/dev/null)" = "$packages" ]; then
  echo "arm64_sysroot: $sysroot is complete"
  exit 0
fi

# Debian's own sources only: what else the host has may not exist for arm64.
sources=/etc/apt/sources.list.d/debian.sources
[ -e "$sources" ] || sources=/etc/apt/sources.list
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/state/lists/partial" "$work/cache/archives/partial" "$work/log"
: >"$work/status"
# An empty status file: apt believes that nothing is installed, and fetches all that the packages depend on.
apt_get() {
  apt-get -q -o APT::Architecture=arm64 -o APT::Architectures::=arm64 -o Dir::Etc::sourcelist="$sources" \
    -o Dir::Etc::sourceparts=- -o Dir::State="$work/state" -o Dir::State::status="$work/status" \
    -o Dir::Cache="$work/cache" -o Dir::Log="$work/log" -o APT::Sandbox::User=root \
    -o APT::Install-Recommends=false "$@"
}
apt_get update
# Unquoted on purpose: $packages is a list.
apt_get install --yes --download-only $packages

for package in "$work"/cache/archives/*.deb; do
  dpkg-deb --extract "$package" "$sysroot"
done
# Links to absolute paths lead out of the sysroot.
find "$sysroot" -type l -lname '/*' | while read -r link; do
  ln -sfn "$(realpath -m --relative-to="$(dirname "$link")" "$sysroot$(readlink "$link")")" "$link"
done
# libccd's CMake package names the libm of a machine where it is installed.
sed -i 's|"/usr/lib/aarch64-linux-gnu/libm.so"|"m"|' "$sysroot"/usr/lib/aarch64-linux-gnu/ccd/*.cmake
printf '%s' "$packages" >"$sysroot/.complete"
echo "arm64_sysroot: $sysroot is ready, $(du -sm "$sysroot" | cut -f1) MB"
