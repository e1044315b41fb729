#!/bin/sh
# Builds the page and the npm package, and serves them on the loopback address.
#   sh scripts/web.sh [build|serve] [PORT]       both, where neither is said; port 8080
# With STEREOTRACE_PAGE, the address at which the page will be, other sites show a preview of links to it.
# STEREOTRACE_SOURCE is the address that its link to the source leads to, and the package's repository.
# The page comes to target/page, a folder that any static web server can serve; the npm package to target/page/pkg. Needs Node 18 or
# newer and npm. wasm-bindgen, of the version in Cargo.lock, is built into target/wasm-bindgen where it is not there, and wasm-opt comes from
# the npm package binaryen, into target/npm.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck disable=SC2034 # setup.sh reads it
adapter=none
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh"
what=both
case ${1-} in build | serve) what=$1; shift ;; esac
port=${1-8080}
site=$root/target/page

# shellcheck source=scripts/node.sh
. "$root/scripts/node.sh"

build() {
    # shellcheck source=scripts/wasm.sh
    . "$root/scripts/wasm.sh"
    version=$(awk '/^name = "wasm-bindgen"$/ { getline; gsub(/version = |"/, ""); print }' "$root/Cargo.lock")
    bindgen=wasm-bindgen
    if [ "$(wasm-bindgen --version 2>/dev/null)" != "wasm-bindgen $version" ]; then
        bindgen=$root/target/wasm-bindgen/bin/wasm-bindgen
        if [ "$("$bindgen" --version 2>/dev/null)" != "wasm-bindgen $version" ]; then
            say "building wasm-bindgen $version"
            # It runs for a second: that it is soon there counts for more than its speed. (Not by its own lock file, which names versions
            # that are no longer to be had.)
            CARGO_PROFILE_RELEASE_OPT_LEVEL=0 CARGO_TARGET_DIR="$root/target/wasm-bindgen/build" \
                cargo install --quiet wasm-bindgen-cli --version "$version" --bin wasm-bindgen --root "$root/target/wasm-bindgen"
        fi
    fi
    npm_package binaryen 132.0.0

    cargo build --manifest-path "$root/Cargo.toml" --package stereotrace-web --target "$target" --profile web
    new=$site.new
    rm -rf "$new"
    mkdir -p "$new/pkg"
    "$bindgen" --target web --out-dir "$new/pkg" "$root/target/$target/web/stereotrace_web.wasm"
    wasm=$new/pkg/stereotrace_web_bg.wasm
    # The features that browsers with WebGPU have, and rustc uses.
    node "$package/bin/wasm-opt" -O2 --enable-bulk-memory --enable-nontrapping-float-to-int --enable-sign-ext \
        --enable-mutable-globals --enable-reference-types --enable-multivalue "$wasm" -o "$wasm.opt"
    mv "$wasm.opt" "$wasm"
    cp "$root"/web/package/index.js "$root"/web/package/index.d.ts "$root"/web/package/package.json "$root"/web/package/README.md "$new/pkg/"
    cp "$root"/LICENSE-* "$new/pkg/"
    if [ -n "${STEREOTRACE_SOURCE-}" ]; then
        (cd "$new/pkg" && npm pkg set repository.type=git "repository.url=$STEREOTRACE_SOURCE")
    fi
    cp "$root"/web/page/* "$root/docs/BROWSER.md" "$new/"
    # Lines with an address that is not said are left out.
    page=${STEREOTRACE_PAGE:+${STEREOTRACE_PAGE%/}/}
    for name in PAGE SOURCE; do
        if [ $name = PAGE ]; then value=$page; else value=${STEREOTRACE_SOURCE-}; fi
        if [ -n "$value" ]; then
            edit="s|@$name@|$(printf '%s' "$value" | sed 's/&/\&amp;/g; s/[&|\\]/\\&/g')|"
        else
            edit="/@$name@/d"
        fi
        sed -i.orig "$edit" "$new/index.html"
    done
    rm "$new/index.html.orig"
    mkdir "$new/example"
    cp "$root"/web/example/* "$new/example/"
    rm -rf "$site"
    mv "$new" "$site"

    bytes=$(gzip -9 -c "$site/pkg/stereotrace_web_bg.wasm" | wc -c)
    echo "wasm: $(wc -c <"$site/pkg/stereotrace_web_bg.wasm") bytes, $bytes as gzip sends it"
    [ "$bytes" -le 2097152 ] || fail "the wasm has more than 2 MiB as gzip sends it"
}

if [ "$what" != serve ]; then build; fi
if [ "$what" != build ]; then
    [ -d "$site" ] || fail "no $site; run: sh scripts/web.sh build"
    exec node "$root/web/serve.mjs" "$site" "$port"
fi
