# SPDX-License-Identifier: MIT
# Shader files to a C table of names and texts (view/program.h), a string for
# each line. A shader is the texts of the files that it includes, each once,
# and its own, whose lines are counted from 1.
BEGIN {
    print "/* Made by the build from src/view/shaders. */"
    print "#include \"view/program.h\"\n"
}
FNR == 1 {
    if (NR > 1)
        print "    ;"
    name = FILENAME
    sub(/.*\//, "", name)
    names[++count] = name
    place[name] = count
    printf "static const char text%d[] =\n    \"#line 1\\n\"\n", count
}
/^#include "/ {
    split($0, words, "\"")
    includes[name] = includes[name] words[2] "\n"
    $0 = ""
}
{
    gsub(/\\/, "\\\\")
    gsub(/"/, "\\\"")
    printf "    \"%s\\n\"\n", $0
}
function add(file, had, all, n, i) {
    if (file in had)
        return
    had[file]
    if (!(file in place)) {
        print "embed.awk: a shader includes " file ", which is not there" \
            > "/dev/stderr"
        exit failed = 1
    }
    n = split(includes[file], all, "\n")
    for (i = 1; i < n; i++)
        add(all[i], had)
    printf "text%d, ", place[file]
}
END {
    if (failed)
        exit 1
    print "    ;\n\nconst view_shader_file view_shader_files[] = {"
    for (i = 1; i <= count; i++) {
        split("", had)
        printf "    {\"%s\", {", names[i]
        add(names[i], had)
        print "0}},"
    }
    print "    {0, {0}}\n};"
}
