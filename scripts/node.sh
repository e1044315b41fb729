# Looks for Node 18 or newer and npm, and installs them where apt-get can; then `npm_package NAME VERSION` unpacks a package of the npm
# registry into target/npm, without running its scripts. Read by scripts that have read setup.sh.
# shellcheck shell=sh
node_is_new_enough() { have node && node -e 'process.exitCode = parseInt(process.versions.node) < 18 ? 1 : 0'; }
if ! node_is_new_enough || ! have npm; then
    have apt-get || fail "this needs Node 18 or newer and npm: see https://nodejs.org"
    if have node && ! have npm; then apt_install npm; else apt_install nodejs npm; fi
    node_is_new_enough || fail "this needs Node 18 or newer, found $(node --version)"
fi

npm_package() { # npm_package NAME VERSION: to target/npm/NAME, and its folder is $package
    package=$root/target/npm/$1/node_modules/$1
    if ! grep -qs "\"version\": \"$2\"" "$package/package.json"; then
        mkdir -p "$root/target/npm/$1"
        npm install --prefix "$root/target/npm/$1" --no-save --no-audit --no-fund --ignore-scripts --loglevel=error "$1@$2" ||
            fail "npm could not install $1 $2"
    fi
}
