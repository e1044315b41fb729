# Looks for Rust's standard library for browsers, $target, and has rustup install it where it is missing.
# shellcheck shell=sh
target=wasm32-unknown-unknown
if [ ! -d "$(rustc --print sysroot)/lib/rustlib/$target" ]; then
    command -v rustup >/dev/null 2>&1 || {
        echo "this needs Rust's standard library for $target; without rustup install your distribution's" >&2
        exit 1
    }
    rustup target add "$target"
fi
