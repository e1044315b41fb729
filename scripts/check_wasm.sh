#!/bin/sh
# Compiles the library for browsers (wasm32-unknown-unknown with WebGPU), alone and with all features that go there. A warning is
# an error. Nothing is run. The target's standard library is installed by rustup where it is missing.
#   sh scripts/check_wasm.sh
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck source=scripts/wasm.sh
. "$root/scripts/wasm.sh"
for features in webgpu webgpu,obj,gltf,ply,png,jpeg,exr,more-textures,sky,json; do
    echo "wasm32: $features"
    # With --target, flags are the target's alone: what is built for this machine stays.
    RUSTFLAGS='-D warnings' cargo check --quiet --manifest-path "$root/Cargo.toml" --package stereotrace --lib --target "$target" \
        --no-default-features --features "$features"
done
