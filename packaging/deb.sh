#!/bin/sh
# SPDX-License-Identifier: MIT
# deb.sh BUILD VERSION: builds Debian's packages in BUILD/deb, of a copy there.
set -eu
deb=$1/deb
tree=$deb/iblbake-$2
export GIT_CEILING_DIRECTORIES="$PWD/.."
rm -rf "$deb"
mkdir -p "$tree"
{ git ls-files 2>/dev/null || find . -type f ! -path './build/*'; } |
    tar -c -T - | tar -x -C "$tree"
[ -e "$tree/REVISION" ] || git describe --always --dirty >"$tree/REVISION"
cp -r packaging/debian "$tree"
sed '1,4d; s/^$/./; s/^/ /' LICENSE >>"$tree/debian/copyright"
cat >"$tree/debian/changelog" <<END
iblbake ($2-1~deb12u1) unstable; urgency=medium

  * See NEWS.md.

 -- $(sed -n 's/^Maintainer: //p' packaging/debian/control)  $(
    date -R -r NEWS.md)
END
cd "$tree"
DEB_BUILD_OPTIONS="noautodbgsym parallel=$(nproc)" \
    dpkg-buildpackage -us -uc -b >../log 2>&1 || {
    tail -n 20 ../log >&2
    echo "iblbake: dpkg-buildpackage failed, see $deb/log" >&2
    exit 1
}
cd ..
rm -rf "iblbake-$2"
ls -l ./*.deb
