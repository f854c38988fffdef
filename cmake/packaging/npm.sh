#!/bin/bash
# Packs the npm package in BUILD/npm as BUILD/packages/oncollide-VERSION.tgz, and tests it as a user would: installed in an
# empty project, without the network. usage: npm.sh BUILD
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
build=$(readlink -f "$1")
command -v npm >/dev/null || { echo "npm.sh: npm is missing; install Debian's npm" >&2; exit 1; }
mkdir -p "$build/packages"
rm -f "$build"/packages/oncollide-*.tgz
( cd "$build/npm" && npm pack --silent --pack-destination "$build/packages" ) >/dev/null
package=$(echo "$build"/packages/oncollide-*.tgz)

project=$(mktemp -d)
trap 'rm -rf "$project"' EXIT
cd "$project"
echo '{ "name": "empty", "version": "1.0.0", "private": true }' >package.json
npm install --silent --offline --no-audit --no-fund "$package"
# The program of the package's README.
sed -n '/^```js$/,/^```$/p' node_modules/oncollide/README.md | sed -n '2,/^```$/p' | sed '/^```$/d' >program.mjs
node program.mjs | tee output
grep -q 'colliding' output && grep -q 'm apart' output
ONCOLLIDE_NPM=$project/node_modules/oncollide node --test "$here/../../clients/web/tests/" >tests || { cat tests; exit 1; }
printf '%s: %d bytes\n' "$package" "$(stat -c %s "$package")"
for wasm in node_modules/oncollide/wasm/*.wasm; do
    printf '%s: %d bytes, gzip %d\n' "$(basename $wasm)" "$(stat -c %s $wasm)" "$(gzip -9c $wasm | wc -c)"
done
