#!/bin/sh
# Runs the tests that compare pictures on two drivers besides the one of scripts/test.sh: SwiftShader's Vulkan and
# llvmpipe's OpenGL. Needs apt-get (Debian and its kin). SwiftShader is not installed: it comes out of the package
# chromium-common, 32 MB, and is unpacked into target/swiftshader. OpenGL's libraries are installed where they are missing.
#   sh scripts/other_drivers.sh
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck disable=SC2034 # setup.sh reads it
adapter=software
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh"
have apt-get || fail "this needs apt-get. With drivers of your own:
    VK_DRIVER_FILES=/path/to/vk_swiftshader_icd.json STEREOTRACE_ADAPTER=swiftshader sh scripts/test.sh
    WGPU_BACKEND=gl sh scripts/test.sh"

swiftshader=$root/target/swiftshader
icd=$swiftshader/usr/lib/chromium/vk_swiftshader_icd.json
if [ ! -f "$icd" ]; then
    rm -rf "$swiftshader"
    mkdir -p "$swiftshader"
    say "unpacking SwiftShader out of chromium-common into $swiftshader"
    download() { (cd "$swiftshader" && apt-get -qq -o APT::Sandbox::User=root download chromium-common); }
    update() { if [ "$(id -u)" = 0 ]; then apt-get update -qq; else sudo -n apt-get update -qq; fi; }
    download 2>/dev/null || { update && download; } ||
        fail "apt-get could not download chromium-common; as root run apt-get update, then this again"
    dpkg -x "$swiftshader"/chromium-common_*.deb "$swiftshader" # the driver itself needs libc alone
    rm -f "$swiftshader"/chromium-common_*.deb
    [ -f "$icd" ] || fail "chromium-common holds no ${icd#"$swiftshader"} any more"
fi
if ! exists /usr/lib/*/libEGL_mesa.so.0 || ! exists /usr/lib/*/dri/swrast_dri.so; then
    apt_install libegl1 libgl1-mesa-dri
fi

tests() { # tests NAME VARIABLE=VALUE...
    say "tests on $1"
    shift
    env "$@" cargo test --manifest-path "$root/Cargo.toml" --test it -- golden:: twins:: geometry:: suite:: limits::
}
# Named, so that no other adapter takes its place.
tests SwiftShader VK_DRIVER_FILES="$icd" VK_ICD_FILENAMES="$icd" STEREOTRACE_ADAPTER=swiftshader
tests "llvmpipe's OpenGL" WGPU_BACKEND=gl STEREOTRACE_ADAPTER=llvmpipe
