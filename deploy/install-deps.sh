#!/usr/bin/env bash
# Installs what Isolux is built, checked and tested with, on Debian 12. As root or with sudo; safe to
# run again: it does nothing where everything is there.
set -euo pipefail

packages=(
  # compiler and tools
  g++ cmake ninja-build ccache git pkg-config clang-format clang-tidy
  # network: gRPC's CMake files name all three
  libgrpc++-dev libgrpc-dev protobuf-compiler-grpc protobuf-compiler libprotobuf-dev
  # geometry, rays, hashes, logs, errors
  libglm-dev libembree-dev libtbb-dev libxxhash-dev libspdlog-dev libfmt-dev libexpected-dev
  # command line, scene files, images, the coordinator's index
  libcli11-dev nlohmann-json3-dev libtinyobjloader-dev libtinygltf-dev libstb-dev libpng-dev
  libopenexr-dev libsqlite3-dev
  # tests and benchmarks
  libgtest-dev libgmock-dev libbenchmark-dev
  # pages are tested in a browser
  chromium
)
# Pages are bundled by node and npm. Packages of node from elsewhere bring npm along and exclude
# Debian's, so what is there is left alone.
if ! command -v node >/dev/null || ! command -v npm >/dev/null; then packages+=(nodejs npm); fi

if [[ ! -r /etc/debian_version ]]; then
  echo "install-deps: this is not Debian; install the packages listed in $0 by other means" >&2
  exit 1
fi

missing=()
for package in "${packages[@]}"; do
  state=$(dpkg-query -W -f='${Status}' "$package" 2>/dev/null || true)
  [[ $state == "install ok installed" ]] || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  echo "install-deps: all ${#packages[@]} packages are installed"
  exit 0
fi

as_root=()
if ((EUID != 0)); then
  if ! command -v sudo >/dev/null; then
    echo "install-deps: run this as root, or install sudo; missing: ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi
echo "install-deps: installing ${missing[*]}"
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -q
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get install -q -y --no-install-recommends "${missing[@]}"
