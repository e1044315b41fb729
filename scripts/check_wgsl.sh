#!/bin/sh
# Shows every distinct kernel to Tint, the WGSL front end of Chrome and Dawn, which refuses some of what naga takes.
#   sh scripts/check_wgsl.sh
# Needs Node 18 or newer and npm, which it installs where apt-get can (tried with Debian's 18.20 and with 20.20), and
# the npm registry once: Dawn's package is unpacked into target/webgpu, 130 MB. No graphics driver is used.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck disable=SC2034 # setup.sh reads it
adapter=any
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh"

node_is_new_enough() { have node && node -e 'process.exitCode = parseInt(process.versions.node) < 18 ? 1 : 0'; }
if ! node_is_new_enough || ! have npm; then
    have apt-get || fail "this needs Node 18 or newer and npm: see https://nodejs.org"
    if have node && ! have npm; then apt_install npm; else apt_install nodejs npm; fi
    node_is_new_enough || fail "this needs Node 18 or newer, found $(node --version)"
fi

version=0.6.2 # of the npm package webgpu
package=$root/target/webgpu/node_modules/webgpu
if ! grep -qs "\"version\": \"$version\"" "$package/package.json"; then
    mkdir -p "$root/target/webgpu"
    npm install --prefix "$root/target/webgpu" --no-save --no-audit --no-fund --ignore-scripts --loglevel=error \
        "webgpu@$version" || fail "npm could not install webgpu $version"
fi

cargo test --quiet --manifest-path "$root/Cargo.toml" --package stereotrace --lib kernels::tests::every_distinct_module_is_written
node "$root/scripts/check_wgsl.mjs" "$root/target/wgsl" "$package/index.js"
