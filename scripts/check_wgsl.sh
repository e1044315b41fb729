#!/bin/sh
# Shows every distinct kernel to Tint, the WGSL front end of Chrome and Dawn, which refuses some of what naga takes.
#   sh scripts/check_wgsl.sh
# Needs Node 18 or newer and npm, which it installs where apt-get can (tried with Debian's 18.20 and with 20.20), and
# the npm registry once: Dawn's package is unpacked into target/npm/webgpu, 130 MB. No graphics driver is used.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck disable=SC2034 # setup.sh reads it
adapter=any
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh"

# shellcheck source=scripts/node.sh
. "$root/scripts/node.sh"
npm_package webgpu 0.6.2

rm -rf "$root/target/wgsl" # a filter that names no test must not leave old modules to check
cargo test --quiet --manifest-path "$root/Cargo.toml" --lib kernel::tests::every_distinct_module_is_written
node "$root/scripts/check_wgsl.mjs" "$root/target/wgsl" "$package/index.js"
