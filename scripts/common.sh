# shellcheck shell=bash
# What the scripts share; to be sourced. Sets the working directory to the project's.

cd "$(dirname "${BASH_SOURCE[0]}")/.."

# Says what happens next.
say() {
    printf '\n== %s\n' "$*"
}

fail() {
    printf '%s: %s\n' "$(basename "$0")" "$*" >&2
    exit 1
}

# Installs those of the named Debian packages that are missing. Touches neither network nor system when none is.
need_packages() {
    local missing=() package
    for package in "$@"; do
        if [ "$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null)" != installed ]; then
            missing+=("$package")
        fi
    done
    if [ ${#missing[@]} -eq 0 ]; then
        return
    fi
    command -v apt-get >/dev/null ||
        fail "these Debian packages are needed and there is no apt-get to install them: ${missing[*]}"
    local as_root=()
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || fail "run this as root, or install sudo; packages to install: ${missing[*]}"
        as_root=(sudo)
    fi
    say "installing Debian packages: ${missing[*]}"
    "${as_root[@]}" apt-get update
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends "${missing[@]}"
}

# Checks for a Rust toolchain; it is not Debian's, whose Rust is too old.
need_cargo() {
    if ! command -v cargo >/dev/null && [ -x "$HOME/.cargo/bin/cargo" ]; then
        PATH="$HOME/.cargo/bin:$PATH"
    fi
    command -v cargo >/dev/null || fail "cargo is missing; install Rust from https://rustup.rs"
}

# Packages to build the C programs and to run OpenGL without a graphics card.
gl_packages=(
    gcc g++ make binutils pkg-config
    libgl-dev libegl-dev libgles-dev libx11-dev libxdamage-dev libglfw3-dev
    libgl1-mesa-dri libglx-mesa0 libegl-mesa0 xvfb
    libvulkan1 libvulkan-dev mesa-vulkan-drivers vulkan-tools vulkan-validationlayers glslang-tools
)
