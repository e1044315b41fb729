#!/bin/sh
# Opens the window of `stereotrace view` on a display of its own and checks what it shows. Needs apt-get (Debian and its kin) for Xvfb, xdotool and
# what winit loads, where they are missing; nothing of that is needed to build.
#   sh scripts/check_view.sh
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
# shellcheck disable=SC2034 # setup.sh reads it
adapter=software
# shellcheck source=scripts/setup.sh
. "$root/scripts/setup.sh"
export STEREOTRACE_ADAPTER=software

missing=
for tool in xvfb-run:xvfb xauth:xauth xdotool:xdotool; do
    have "${tool%%:*}" || missing="$missing ${tool##*:}"
done
for library in libX11-xcb.so.1:libx11-xcb1 libXcursor.so.1:libxcursor1 libXi.so.6:libxi6 libXrandr.so.2:libxrandr2 \
    libxkbcommon-x11.so.0:libxkbcommon-x11-0; do
    exists /usr/lib/*/"${library%%:*}" || missing="$missing ${library##*:}"
done
if [ -n "$missing" ]; then
    have apt-get || fail "this needs apt-get, or in Debian's package names:$missing"
    # shellcheck disable=SC2086 # a list of packages
    apt_install $missing
fi

# Built before the clock runs: a window that does not close is a failure, not something to wait for.
cargo test --manifest-path "$root/Cargo.toml" --test window --no-run
screen=$(mktemp -d)
trap 'rm -rf "$screen"' EXIT
say "opening windows of stereotrace view"
STEREOTRACE_FRAMEBUFFER=$screen/Xvfb_screen0 timeout -k 10 300 \
    xvfb-run -a -s "-screen 0 800x600x24 -fbdir $screen" \
    cargo test --manifest-path "$root/Cargo.toml" --test window -- --ignored --test-threads 1
