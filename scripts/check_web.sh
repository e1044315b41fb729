#!/bin/sh
# Builds the page and the npm package (scripts/web.sh) and tests them in a headless Chromium on SwiftShader, against what the library renders
# natively on the same driver. Needs apt-get where Chromium or Node are not there. Screenshots and figures come to target/web-test.
#   sh scripts/check_web.sh [full]      with full, a pair of 512x512 is timed in the browser and natively
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck disable=SC2034 # setup.sh reads it
adapter=none
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh"
# shellcheck source=scripts/chromium.sh
. "$root/scripts/chromium.sh"

sh "$root/scripts/web.sh" build

# The types of the package, and of the page's own scripts.
npm_package typescript 7.0.2
node "$package/bin/tsc" --project "$root/web/test/tsconfig.json"
node "$package/bin/tsc" --project "$root/web/test/tsconfig.strict.json"
npm_package axe-core 4.10.3
axe=$package
npm_package iwer 2.5.0
iwer=$package
npm_package playwright-core 1.60.0
cargo build --quiet --manifest-path "$root/Cargo.toml" --example web_native
native=$(cargo metadata --manifest-path "$root/Cargo.toml" --format-version 1 --no-deps | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')/debug/examples/web_native
VK_DRIVER_FILES=$icd VK_ICD_FILENAMES=$icd STEREOTRACE_ADAPTER=swiftshader \
    node "$root/web/test/page.mjs" "$root/target/page" "$root/target/web-test" "$package" "$(command -v chromium)" "$native" "$root/scenes" "$axe" "$iwer" ${1+"$1"}
