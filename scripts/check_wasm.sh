#!/bin/sh
# Checks the library for browsers (wasm32-unknown-unknown with WebGPU), alone and with all features that work there, and
# the crate of the page. A warning is an error. Nothing is run. rustup installs the target's standard library if it is
# missing.
#   sh scripts/check_wasm.sh
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck source=scripts/wasm.sh
. "$root/scripts/wasm.sh"
# A browser's GPU objects can't cross threads.
lints='-D warnings -A clippy::arc_with_non_send_sync'
for features in webgpu webgpu,obj,gltf,ply,png,jpeg,exr,more-textures,sky,json; do
    echo "wasm32: $features"
    # shellcheck disable=SC2086 # a list of lints
    cargo clippy --quiet --manifest-path "$root/Cargo.toml" --package stereotrace --lib --target "$target" \
        --no-default-features --features "$features" -- $lints
done
cargo clippy --quiet --manifest-path "$root/Cargo.toml" --package stereotrace-web --target "$target" --no-deps -- -D warnings
