#!/bin/sh
# Checks the library with some of its features, and the command without its own. A warning is an error.
#   sh scripts/check_features.sh          groups of features that do not need each other, some minutes
#   sh scripts/check_features.sh alone    each feature alone
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
cd "$root"
groups='obj,ply,png,sky,exr gltf,jpeg,json,serde,more-textures dataset'
[ "${1-}" = alone ] && groups='obj gltf ply png jpeg exr json textures more-textures sky serde dataset'
# The tests block, on an adapter of this machine.
cargo clippy --package stereotrace --all-targets --no-default-features --features native,blocking -- -D warnings
for features in $groups; do
    cargo clippy --package stereotrace --lib --no-default-features --features native,blocking,"$features" -- -D warnings
done
cargo clippy --package stereotrace --no-default-features -- -D warnings
cargo clippy --package stereotrace-cli --no-default-features -- -D warnings
