#!/bin/sh
# Installs the npm package from its tarball into projects of Vite, webpack and esbuild, builds them, and renders a pair
# with each in a headless Chromium on SwiftShader. Needs the npm registry, and apt-get where Chromium is not there.
# Projects and logs come to target/bundlers.
#   sh scripts/check_bundlers.sh
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck disable=SC2034 # setup.sh reads it
adapter=none
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh"
# shellcheck source=scripts/chromium.sh
. "$root/scripts/chromium.sh"
[ -d "$root/target/page/pkg" ] || sh "$root/scripts/web.sh" build

npm_package playwright-core 1.60.0
playwright=$package
work=$root/target/bundlers
rm -rf "$work"
mkdir -p "$work"
cp -r "$root/web/test/bundlers/." "$work"
cd "$work"
npm pack --silent --pack-destination "$work" "$root/target/page/pkg" >/dev/null
npm install --no-audit --no-fund --ignore-scripts --loglevel=error ./stereotrace-*.tgz \
    vite@8.3.4 webpack@5.113.0 webpack-cli@7.3.1 esbuild@0.28.2 || fail 'npm could not install the bundlers'
npm ls --depth=0

npx vite build --outDir dist/vite
npx webpack --config webpack.config.mjs
for format in esm iife; do
    npx esbuild main.esbuild.js --bundle --format=$format --loader:.wasm=file --outfile=dist/esbuild-$format/main.js
done
# A script of a module, and plain ones.
echo '<!doctype html><script type="module" src="main.js"></script>' >dist/esbuild-esm/index.html
for plain in webpack esbuild-iife; do echo '<!doctype html><script src="main.js"></script>' >dist/$plain/index.html; done
mkdir -p dist/none
cp -r node_modules/stereotrace dist/none/stereotrace
cp picture.js dist/none
cp none.html dist/none/index.html
VK_DRIVER_FILES=$icd VK_ICD_FILENAMES=$icd node check.mjs "$playwright" "$(command -v chromium)" "$root/web/serve.mjs"
