#!/bin/bash
# SPDX-License-Identifier: MIT
# The manual pages and --help name the same options with the same ranges and
# defaults (check-pairs.sh runs each option of --help); man/iblbake-NAME.1 is the page of `iblbake NAME`, and
# man/iblview.1 that of the viewer, where that was built. BUILD names the build.
set -u
. tests/lib.sh
need mandoc man
program=$build/iblbake

check_page() { # PAGE, of the command in run
    page=$1
    # One line an option: its forms as --help writes them, a tab, the
    # explanation.
    "${run[@]}" --help >"$work/printed"
    awk '
        /^  -|^      --/ {
            if (entry) print entry "\t" text
            split(substr($0, 3), part, /   +| +[a-z0-9A-Z].*   /)
            entry = substr($0, 1, 26); text = substr($0, 28)
            if (length($0) < 29 || substr($0, 27, 1) != " ") {
                entry = $0; text = ""
            }
            gsub(/^ +| +$/, "", entry)
            next
        }
        /^                           / && entry {
            sub(/^ */, ""); text = text " " $0; next
        }
        { if (entry) print entry "\t" text; entry = "" }
        END { if (entry) print entry "\t" text }' "$work/printed" >"$work/help"

    # The same of the page: "-o, --output DIR", from
    # ".It Fl o , Fl -output Ar DIR".
    sed -n '/^\.Sh DESCRIPTION/,/^\.Sh ENVIRONMENT/s/^\.It \(Fl .*\)/\1/p' \
        "$page" | sed 's/Fl /-/g; s/ , /, /; s/ Ar / /' >"$work/page"
    verdict "$page: options of page and --help" \
        "$(cut -f 1 "$work/help" | diff - "$work/page")"

    # Ranges and defaults: what --help has in its last parentheses must be in
    # the page under the option, in the same words.
    # (Bold is written as a letter, a backspace and the letter again.)
    mandoc -Tascii -O width=1000 "$page" | sed 's/.\x08//g' >"$work/text"
    awk -F '\t' '
        function flat(s) { gsub(/[ \n]+/, " ", s); return s }
        FNR == NR {
            if ($0 ~ /^ *-/) { at++; sub(/^ +/, "") }
            block[at] = block[at] " " $0
            if ($0 ~ /^-/) head[at] = $0 " "
            next
        }
        match($2, / \([^()]*(\(both 0\)[^()]*)?\)$/) {
            facts = substr($2, RSTART + 2, RLENGTH - 3); text = ""
            for (i = 1; i <= at; i++)
                if (index(head[i], $1 " ") == 1) text = text flat(block[i])
            for (i = split(facts, fact, "; "); i > 0; i--)
                if (!index(text, fact[i])) print $1 ": no " fact[i] " under it"
        }' "$work/text" "$work/help" >"$work/why"
    verdict "$page: ranges and defaults" "$(cat "$work/why")"

    # The headings of --help are headings of the page, as it is read: a word
    # that is a macro of mdoc would be another there.
    MANWIDTH=80 man -l "$page" 2>"$work/man" | sed 's/.\x08//g' >"$work/read"
    sed -n 's/^\([A-Z][A-Za-z ]*\):$/\1/p' "$work/printed" |
        while read -r heading; do
            has "^ *$heading\$" "$work/read"
        done >"$work/why"
    verdict "$page: headings" "$(cat "$work/why")"

    # Short forms parse.
    verdict "$page: -h" "$("${run[@]}" -h | cmp - "$work/printed")"
    verdict "$page: columns" "$(awk 'length > 80' "$work/printed")"
    verdict "$page: named by --help" "$(
        has "man $(basename "$page" .1)\$" "$work/printed")"
    verdict "$page: man" "$(cat "$work/man")"
    verdict "$page: mandoc" "$(mandoc -Tlint -Wstyle "$page" 2>&1 |
        grep -v outdated)"
}

# Each command that --help lists has a page, and each page is of a command.
run=("$program")
check_page man/iblbake.1
"$program" --help | sed -n 's/^  iblbake \([a-z-]*\) .*/\1/p' >"$work/commands"
ls man | sed -n 's/^iblbake-\(.*\)\.1$/\1/p' | sort |
    diff - <(sort "$work/commands") >"$work/why"
verdict 'pages and commands' "$(cat "$work/why")"
for name in $(cat "$work/commands"); do
    run=("$program" "$name")
    [ ! -e "man/iblbake-$name.1" ] || check_page "man/iblbake-$name.1"
done
if [ -x "$build/iblview" ]; then
    run=("$build/iblview")
    check_page man/iblview.1
    # Keys: those of --keys, in its order and words.
    "$build/iblview" --keys | sed '/./!d; s/^ *//' | tr -s ' ' >"$work/keys"
    mandoc -Tascii -O width=1000 man/iblview.1 | sed 's/.\x08//g; s/^ *//' |
        sed -n '/goes the other way/,/^With the mouse/{//d; /./p}' |
        tr -s ' ' >"$work/page"
    verdict 'man/iblview.1: keys' "$(diff "$work/keys" "$work/page")"
else
    verdict 'man/iblview.1: options' 'skipped: iblview was not built'
fi

# The pages that explain: they format, and their options are options.
for page in man/*.7; do
    verdict "$page: man" "$(MANWIDTH=80 man -l "$page" 2>&1 >/dev/null)"
    verdict "$page: mandoc" "$(mandoc -Tlint -Wstyle "$page" 2>&1)"
    sed -n 's/.*Fl -\([a-z-]*\).*/\1/p' "$page" | sort -u |
        while read -r name; do
            has "^\.It Fl .*-$name\( \|\$\)" man/iblbake.1
        done >"$work/why"
    verdict "$page: options that there are not" "$(cat "$work/why")"
done

# What the page of the engines shows of a target is what the program has: its
# options, the lines that load and those of a light.
page=man/iblbake-engines.7
"$program" --target list | sed -n 's/^\([a-z-]*\): .*/\1/p' >"$work/targets"
sed -n 's/^\.Ss //p' "$page" | diff "$work/targets" - >"$work/why"
verdict "$page: targets" "$(cat "$work/why")"
while read -r target; do
    {
        "$program" --target list |
            sed -n "/^$target: /,/^[a-z-]*: /s/^    //p"
        "$program" --target "$target" --explain --sun |
            sed '/^.. Reflections: /,/^.. Reflections end/c\{reflections}'
    } >"$work/printed"
    awk -v target="$target" '
        /^\.S[sh] / { on = $2 == target }
        /^\.Ed/ { literal = 0 }
        /^{reflections / { $0 = "{reflections}" }
        on && literal && !/^\.\\"/
        /^\.Bd -literal/ { literal = 1 }' "$page" |
        sed "s/\\\\(aq/'/g; s/\\\\e/\\\\/g" | diff "$work/printed" - >"$work/why"
    verdict "$page: $target" "$(cat "$work/why")"
done <"$work/targets"

sed -n '/^| `--target` | bytes/,/^$/p' README.md | sed '$d' >"$work/rows"
awk -v readme=1 -f src/cli/targets.awk "$page" | diff "$work/rows" - >"$work/why"
verdict "README.md: targets" "$(cat "$work/why")"

# Pages name no page that is not there, and every other one.
for page in man/*.[17]; do
    sed -n 's/.*Sy \(ibl[a-z-]*\) Ns (\([17]\)).*/man\/\1.\2/p' "$page" |
        sort -u | while read -r other; do
        there "$other"
    done >"$work/why"
    sed -n '/^\.Sh SEE ALSO/,$p' "$page" >"$work/also"
    for other in man/*.[17]; do
        name=$(basename "${other%.*}")
        [ "$other" = "$page" ] ||
            has "^\.Sy $name Ns (${other##*.})" "$work/also"
    done >>"$work/why"
    verdict "$page: other pages" "$(cat "$work/why")"
done
end
