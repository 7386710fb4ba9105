#!/bin/sh
# Installs, on Debian 12, everything that building and testing Cloister needs. Run it as root or as a user with sudo, as
# often as you like: what is there already is left alone.
set -eu

# One package a line, each with its reason.
packages=$(sed 's/#.*//' <<'LIST'
g++                # compiler
cmake              # build system; 3.25 for workflow presets
ninja-build        # the presets' generator
libeigen3-dev      # linear algebra
libexpected-dev    # tl::expected behind Result
libhwy-dev         # vectors for whatever the processor has, chosen at run time
libccd-dev         # early "no" on oriented boxes
libboost-dev       # lockfree::spsc_queue, headers only
libtbb-dev         # parallel overlap comparisons; OpenVDB's headers use it too
libtomlplusplus-dev # configuration files
libcli11-dev       # command lines
nlohmann-json3-dev # sensor metadata, mission and result files
libpcap-dev        # pcap and pcapng captures
liblzf-dev         # compressed bodies of PCD files
libxxhash-dev      # hash of the map, checksums of the map file
cyclonedds-dev     # DDS: live scans, odometry and graphs in, map and diagnostics out
cyclonedds-tools   # idlc, the compiler of message definitions
libiceoryx-binding-c-dev # shared memory below DDS, asked whether its daemon lives
libiceoryx-posh-dev # the CMake package of the line above needs it
libiceoryx-hoofs-dev # and this
iceoryx            # iox-roudi, that daemon, for the tests
libsqlite3-dev     # rosbag2 recordings
liboctomap-dev     # export to .bt and .ot
libopenvdb-dev     # export to .vdb
libimath-dev       # half floats in OpenVDB's headers
libembree-dev      # rays of the simulator, distances of the ground-truth tool
iproute2           # networks that tests lay between namespaces
nftables           # and the translation of addresses there
doctest-dev        # unit tests
libbenchmark-dev   # harness of the kernel benchmarks
clang              # libFuzzer targets
libclang-rt-14-dev # libFuzzer's and the sanitizers' runtimes for it
LIST
)

missing=
for package in $packages; do
  status=$(dpkg-query --show --showformat '${db:Status-Status}' "$package" 2>/dev/null) || status=
  [ "$status" = installed ] || missing="$missing $package"
done
if [ -z "$missing" ]; then
  echo "setup: everything is installed"
  exit 0
fi

if [ "$(id -u)" -eq 0 ]; then
  as_root=
elif command -v sudo >/dev/null; then
  as_root=sudo
else
  echo "setup: packages are missing and there is no sudo; as root, run: apt-get install$missing" >&2
  exit 1
fi

echo "setup: installing$missing"
$as_root apt-get update
# Unquoted on purpose: $as_root may be nothing, $missing is a list.
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends $missing
