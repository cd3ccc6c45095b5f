#!/usr/bin/env bash
# Installs what building hfvdb needs, and nothing that is there already. Safe to run again.
#
#   scripts/install.sh           OpenVDB and its headers, a C++ compiler
#   scripts/install.sh --tests   also OpenVDB's own tools and its Python module, Blender as a Python module (.venv),
#                                Houdini's type stubs (.venv-houdini), Rust's formatter and linter
#
# Debian 12 or newer, or another system with apt. Packages are installed as root, by sudo where needed.
# HFVDB_BLENDER_PYTHON names a Python 3.11 that has bpy already; then .venv is not made.
set -euo pipefail
cd "$(dirname "$0")/.."

readonly rust_needed=1.95
readonly bpy_version=5.0.1
readonly numpy_version=1.26.4
# What checks houdini_examples without Houdini.
readonly type_packages=(mypy==2.4.1 types-houdini==21.0.512.3 types-usd==24.5.2)

build_packages=(
    g++ make pkg-config
    libopenvdb-dev libnanovdb-dev libboost-dev libtbb-dev libblosc-dev libimath-dev zlib1g-dev
)
test_packages=(
    # The outside judges: OpenVDB's own tools and its Python module.
    libopenvdb-tools python3-openvdb python3-numpy python3-venv
    # What bpy is linked to and does not bring along.
    libgl1 libopengl0 libsm6 libice6 libx11-6 libxext6 libxfixes3 libxi6 libxkbcommon0 libxrender1 libxt6 libuuid1
)

say() { printf 'install: %s\n' "$*"; }
fail() {
    printf 'install: %s\n' "$*" >&2
    exit 1
}

is_installed() {
    [ "$(dpkg-query --show --showformat='${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

install_packages() {
    local missing=() package as_root=()
    command -v dpkg-query >/dev/null || fail "this system has no apt; install the counterparts of: $*"
    for package in "$@"; do
        is_installed "$package" || missing+=("$package")
    done
    if [ ${#missing[@]} -eq 0 ]; then
        say "all Debian packages are there"
        return
    fi
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || fail "run this as root, or install these packages: ${missing[*]}"
        as_root=(sudo)
    fi
    say "installing Debian packages: ${missing[*]}"
    "${as_root[@]}" apt-get update --quiet=2
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get install --yes --quiet=2 --no-install-recommends "${missing[@]}"
}

check_rust() {
    local version
    command -v cargo >/dev/null \
        || fail "Rust is missing: install version $rust_needed or newer (https://rustup.rs), then run this again"
    version=$(cargo --version | cut -d' ' -f2)
    [ "$(printf '%s\n' "$rust_needed" "$version" | sort --version-sort | head -n 1)" = "$rust_needed" ] \
        || fail "Rust $version is too old: hfvdb needs $rust_needed or newer; try: rustup update stable"
    say "Rust $version is there"
}

check_rust_tools() {
    local tool
    for tool in rustfmt clippy; do
        cargo "${tool/rust/}" --version >/dev/null 2>&1 && continue
        command -v rustup >/dev/null || fail "$tool is missing, and so is rustup, which would install it"
        say "installing $tool"
        rustup component add "$tool"
    done
}

install_blender() {
    local python installed
    if [ -n "${HFVDB_BLENDER_PYTHON:-}" ]; then
        say "Blender is taken from $HFVDB_BLENDER_PYTHON (HFVDB_BLENDER_PYTHON)"
        return
    fi
    installed=$(.venv/bin/python -c 'import importlib.metadata as m; print(m.version("bpy"), m.version("numpy"))' \
        2>/dev/null || true)
    if [ "$installed" = "$bpy_version $numpy_version" ]; then
        say "Blender $bpy_version is there, in .venv"
        return
    fi
    python=$(command -v /usr/bin/python3.11 || command -v python3.11) \
        || fail "bpy $bpy_version needs Python 3.11, which is not here"
    say "installing Blender $bpy_version as a Python module into .venv (about 400 MB)"
    "$python" -m venv .venv
    .venv/bin/python -m pip install --quiet --disable-pip-version-check \
        "bpy==$bpy_version" "numpy==$numpy_version"
}

install_type_checker() {
    local installed package
    installed=$(.venv-houdini/bin/python -m pip freeze --disable-pip-version-check 2>/dev/null || true)
    for package in "${type_packages[@]}"; do
        grep --quiet --line-regexp --fixed-strings "$package" <<<"$installed" && continue
        say "installing the type stubs of Houdini and mypy into .venv-houdini"
        /usr/bin/python3 -m venv .venv-houdini
        .venv-houdini/bin/python -m pip install --quiet --disable-pip-version-check "${type_packages[@]}"
        return
    done
    say "the type stubs of Houdini are there, in .venv-houdini"
}

case "${1:-}" in
    "") install_packages "${build_packages[@]}" && check_rust ;;
    --tests)
        install_packages "${build_packages[@]}" "${test_packages[@]}"
        check_rust
        check_rust_tools
        install_blender
        install_type_checker
        ;;
    *) fail "usage: scripts/install.sh [--tests]" ;;
esac
say "done"
