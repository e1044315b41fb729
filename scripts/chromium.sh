# Looks for Debian's Chromium and for Node, and installs them where apt-get can. $icd is then the SwiftShader of the
# same build as the browser's, for programs beside it. Read by scripts that have read setup.sh.
# shellcheck shell=sh
# shellcheck source=scripts/node.sh
. "$root/scripts/node.sh"
have chromium || apt_install chromium
icd=/usr/lib/chromium/vk_swiftshader_icd.json
[ -f "$icd" ] || fail "no $icd: Debian's chromium has it"
