#!/bin/sh
# Checks the library for browsers (wasm32-unknown-unknown with WebGPU), alone and with all features that work there, and
# the crate of the page. A warning is an error. Nothing is run. rustup installs the target's standard library if it is
# missing.
#   sh scripts/check_wasm.sh
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck source=scripts/wasm.sh
. "$root/scripts/wasm.sh"
for features in webgpu webgpu,obj,gltf,ply,png,jpeg,exr,more-textures,sky,json; do
    echo "wasm32: $features"
    cargo clippy --quiet --manifest-path "$root/Cargo.toml" --package stereotrace --lib --target "$target" \
        --no-default-features --features "$features" -- -D warnings
done
cargo clippy --quiet --manifest-path "$root/Cargo.toml" --package stereotrace-web --target "$target" --no-deps -- -D warnings
