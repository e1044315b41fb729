# Looks for what building and running needs, and installs what apt-get can: a C linker and Mesa's software Vulkan driver.
#   root=REPOSITORY adapter=any|software|none; . scripts/setup.sh     (or: sh scripts/setup.sh)
# adapter=any wants something to render with, a GPU or not; adapter=software wants the software driver beside any GPU;
# adapter=none wants none.
# Asks nothing, except that sudo may want a password at a terminal; a second run installs nothing.
# shellcheck shell=sh
set -eu
root=${root:-$(dirname "$0")/..}
adapter=${adapter:-any}

say() { echo "set-up: $*"; }
fail() { say "$*" >&2; exit 1; }
have() { command -v "$1" >/dev/null 2>&1; }
exists() { [ -e "$1" ]; } # given a glob: does its first match exist?

# --- Rust ---

rust_wanted=$(sed -n 's/^rust-version *= *"\(.*\)".*/\1/p' "$root/Cargo.toml")
rust_found() { rustc --version 2>/dev/null | cut -d ' ' -f 2; }
rust_is_new_enough() {
    have cargo && awk -v have="$(rust_found)" -v want="$rust_wanted" 'BEGIN {
        split(have, h, "."); split(want, w, ".")
        for (i = 1; i <= 3; i++) if (h[i] + 0 != w[i] + 0) exit (h[i] + 0 < w[i] + 0)
    }'
}

# rustup's Rust may be installed, but not yet on this shell's PATH, or behind the distribution's.
rustup_env=${CARGO_HOME:-${HOME:-}/.cargo}/env
if ! rust_is_new_enough && [ -f "$rustup_env" ]; then
    # shellcheck source=/dev/null
    . "$rustup_env"
fi
if ! rust_is_new_enough; then
    found="no rustc"
    if have rustc; then found=$(rustc --version 2>&1 | head -n 1) || true; fi
    have cargo || found="$found, no cargo"
    fail "this needs cargo and Rust $rust_wanted or newer, found: $found (Debian's own is too old). Install it with
    curl --proto '=https' --tlsv1.2 -sSf https://sh.rustup.rs | sh -s -- -y
    . \"\$HOME/.cargo/env\"
(where rustup is there already: rustup update stable) and run this again."
fi

# Without a session Mesa's device chooser prints an error line about XDG_RUNTIME_DIR that means nothing here.
[ -n "${XDG_RUNTIME_DIR:-}" ] || export NODEVICE_SELECT=1

# --- Adapters: a Vulkan loader, and a driver's ICD file that it finds ---

vulkan_loader() {
    exists /usr/lib/libvulkan.so.1 || exists /usr/lib64/libvulkan.so.1 || exists /usr/local/lib/libvulkan.so.1 ||
        exists /usr/lib/*-linux-*/libvulkan.so.1 || ldconfig -p 2>/dev/null | grep 'libvulkan\.so\.1' >/dev/null
}
# shellcheck disable=SC2086 # $1 is a glob
icd() { exists /usr/share/vulkan/icd.d/$1 || exists /etc/vulkan/icd.d/$1; }
software_adapter() {
    case $(uname -s) in
    Darwin) return 1 ;;
    MINGW* | MSYS* | CYGWIN*) return 0 ;; # WARP, part of DirectX 12
    esac
    vulkan_loader && { [ -n "${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}" ] || icd 'lvp_icd*.json'; }
}
# A driver's ICD file does not prove that its GPU is there: the device file does.
any_adapter() {
    [ "$(uname -s)" = Darwin ] || software_adapter || { vulkan_loader && {
        { exists /dev/nvidia0 && icd 'nvidia*.json'; } || { exists /dev/dri/renderD* && icd '*.json'; }
    }; }
}
adapter_found() {
    case $adapter in
    none) return 0 ;;
    software) software_adapter ;;
    *) any_adapter ;;
    esac
}

# --- Install what is missing ---

as_root() {
    if [ "$(id -u)" = 0 ]; then
        "$@"
    elif have sudo && { sudo -n true 2>/dev/null || [ -t 0 ]; }; then
        sudo "$@"
    else
        fail "installing needs root and sudo is not there or wants a password; as root run: apt-get install $packages"
    fi
}
apt_install() { # apt_install PACKAGE...
    packages=$*
    say "installing with apt-get, which may take a minute: $packages"
    as_root apt-get -o DPkg::Lock::Timeout=120 update -qq || say "apt-get update failed; trying with the old package list"
    as_root env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=120 \
        install -y -qq --no-install-recommends "$@" >/dev/null || fail "apt-get could not install $packages"
}

missing=
case $(uname -s) in
MINGW* | MSYS* | CYGWIN*) ;; # Rust brings its own ways to link there
*) have cc || missing="gcc libc6-dev" ;;
esac
adapter_found || missing="${missing:+$missing }mesa-vulkan-drivers"

if [ -z "$missing" ]; then
    say "Rust $(rust_found), a linker and an adapter ($adapter) are there: nothing to install"
elif have apt-get; then
    # shellcheck disable=SC2086 # a list of packages
    apt_install $missing
    have cc || fail "there is still no C linker named cc"
    adapter_found || fail "there is still no Vulkan driver (adapter=$adapter): no libvulkan.so.1, or no lvp_icd*.json in /usr/share/vulkan/icd.d"
    say "installed; Rust $(rust_found), a linker and an adapter ($adapter) are there"
elif [ "$(uname -s)" = Darwin ]; then
    have cc || fail "there is no C linker named cc; install it with: xcode-select --install"
    fail "macOS renders on Metal and has no software adapter, which the tests use by default.
To test on the GPU, name it or a part of it: STEREOTRACE_ADAPTER=Apple sh scripts/test.sh"
else
    fail "missing here, in Debian's package names: $missing. Install
    on Fedora: dnf install gcc mesa-vulkan-drivers vulkan-loader
    on Arch:   pacman -S gcc vulkan-swrast vulkan-icd-loader
and run this again. A driver elsewhere is found through VK_DRIVER_FILES=/path/to/its_icd.json."
fi
