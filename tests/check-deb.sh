#!/bin/bash
# SPDX-License-Identifier: MIT
# Debian's packages, as `make deb` builds them, in a root of their own that has
# nothing but Debian's smallest system: what each needs and has, that what is
# installed works, and that nothing of it stays when it is purged.
set -u
. tests/lib.sh
need dpkg-buildpackage dh lintian debootstrap apt-get chroot
[ "$(id -u)" = 0 ] || skip_all 'only root makes a root of its own'
version=$(sed -n 's/^.define IBL_VERSION "\(.*\)"/\1/p' include/ibl/ibl.h)
root=$work/root
suite=$(. /etc/os-release && echo "$VERSION_CODENAME")

# Those of this tree may be there.
built=$(echo "$build"/deb/iblbake_*.deb)
[ -e "$built" ] && [ -z "$(find src include man packaging Makefile NEWS.md \
    data tests/symbols.txt -type f -newer "$built" | head -n 1)" ] ||
    ok build sh packaging/deb.sh "$build" "$version"
cd "$build/deb" || exit 1
names='iblbake iblview libiblbake1 libiblbake-dev'
for name in $names; do
    ok "there-is-$name" test -s "$name"_*.deb
done
verdict no-others "$(for deb in *.deb; do
    case " $names " in *" ${deb%%_*} "*) ;; *) echo "$deb" ;; esac; done)"
verdict lintian "$(lintian --allow-root ./*.changes 2>&1)"

# What they need and recommend.
field() { dpkg-deb -f "$1"_*.deb "$2"; }
lacks() { # NAME FIELD PATTERN
    [[ ! $(field "$1" "$2") =~ $3 ]] || echo "$2: found '$(field "$1" "$2")', wanted no $3"
}
has() { # NAME FIELD PATTERN
    [[ $(field "$1" "$2") =~ $3 ]] || echo "$2: found '$(field "$1" "$2")', wanted $3"
}
verdict openimageio-recommended "$(has iblbake Recommends libopenimageio
    lacks iblbake Depends libopenimageio)"
verdict no-gl "$(lacks iblbake Depends 'libgl|libglfw|libx11'
    has iblview Depends libglfw)"
verdict library "$(has libiblbake-dev Depends 'libiblbake1 \(= '
    dpkg-deb --ctrl-tarfile libiblbake1_*.deb | tar -xO ./symbols |
        sed -n 's/^ \(.*\)@Base .*/\1/p' | diff - <(sort "$top/tests/symbols.txt"))"

# The smallest system.
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' \
    'Origin: Debian' "Codename: $suite" | head -n 1)
export DEBIAN_FRONTEND=noninteractive LC_ALL=C
debootstrap --variant=minbase --cache-dir=/var/cache/apt/archives "$suite" \
    "$root" "$mirror" >"$work/log" 2>&1 || {
    verdict root "skipped: debootstrap: $(tail -n 1 "$work/log")"
    end
    exit
}
files() { # of the root, without what dpkg writes down
    (cd "$root" && find . -xdev \( -path ./tmp -o -path ./var/lib/dpkg -o \
        -path ./var/log -o -path ./var/cache \) -prune -o -print | sort)
}
files >"$work/before"
installed() {
    dpkg --root="$root" -l | awk '$1 ~ /^i/ { sub(/:.*/, "", $2); print $2 }' | sort
}
installed >"$work/system"
# What they depend on, by the system's apt, as the root has it.
in_root() { chroot "$root" "$@"; }
install() { # NAME...
    local deb apt=(apt-get -qq --no-install-recommends
        -o Dir::State::status="$root/var/lib/dpkg/status")
    # shellcheck disable=SC2046
    "${apt[@]}" --download-only install $(printf './%s_*.deb ' "$@") 2>&1 >/dev/null
    # shellcheck disable=SC2046
    for deb in $("${apt[@]}" -s install $(printf './%s_*.deb ' "$@") |
        sed -n 's/^Inst \([^ ]*\) .*(\([^ ]*\) .*/\1_\2/p' | sed 's/:/%3a/g'); do
        cp "/var/cache/apt/archives/$deb"_*.deb "$root/tmp" 2>/dev/null ||
            cp "$deb"_*.deb "$root/tmp"
    done
    in_root sh -c 'dpkg -i /tmp/*.deb && rm /tmp/*.deb' >"$work/log" 2>&1 ||
        tail -n 5 "$work/log"
}

verdict install-iblbake "$(install iblbake)"
verdict root-without-gl "$(installed | grep -E '^lib(gl|egl|x11|opengl)')"
cp "$top"/data/{sky,studio}.exr "$root/tmp"
ok bake in_root iblbake -q /tmp/sky.exr -o /tmp/out --size 32
ok its-files test -s "$root/tmp/out/sky_specular.ktx2"
ok dwa in_root iblbake -q /tmp/studio.exr -o /tmp/out --size 32
ok manual test -s "$root/usr/share/man/man1/iblbake.1.gz"
printf 'II*\0\10\0\0\0\0\0' >"$root/tmp/map.tif"
verdict says-what-to-install "$(in_root iblbake /tmp/map.tif -o /tmp/out 2>&1 |
    grep -v 'install the package libopenimageio')"
verdict install-others "$(install libiblbake1 libiblbake-dev iblview)"
ok view in_root iblview --version
ok headers test -s "$root/usr/include/ibl/ibl.h"
verdict libraries "$(in_root sh -c 'ldd /usr/bin/iblview /usr/lib/*/libiblbake.so' |
    grep 'not found')"

# shellcheck disable=SC2046,SC2086
ok purge in_root dpkg --purge $(installed | comm -13 "$work/system" -)
verdict nothing-left "$(files | diff "$work/before" - | grep '^>' | head -n 5)"
verdict no-package-left "$(dpkg --root="$root" -l 'ibl*' 'libibl*' 2>/dev/null |
    grep '^[ir]')"
cd "$top" || exit 1
end
