# SPDX-License-Identifier: MIT
# Shader files to a C table of names and texts (view/gl.h), a string for
# each line. A shader is the texts of the files that it includes, each once,
# and its own; the lines of each are counted from 1.
FNR == 1 {
    name = FILENAME
    sub(/.*\//, "", name)
    names[++count] = name
    text[name] = "    \"#line 1\\n\"\n"
}
/^#include "/ {
    split($0, words, "\"")
    includes[name] = includes[name] words[2] "\n"
    $0 = ""
}
{
    gsub(/\\/, "\\\\")
    gsub(/"/, "\\\"")
    text[name] = text[name] "    \"" $0 "\\n\"\n"
}
function add(file, had, all, n, i) {
    if (had[file]++)
        return
    if (!(file in text)) {
        print "embed.awk: a shader includes " file ", which is not there" \
            > "/dev/stderr"
        exit 1
    }
    n = split(includes[file], all, "\n")
    for (i = 1; i < n; i++)
        add(all[i], had)
    printf "%s", text[file]
}
END {
    print "/* Made by the build from src/view/shaders. */"
    print "#include \"view/gl.h\"\n"
    print "const view_shader_file view_shader_files[] = {"
    for (i = 1; i <= count; i++) {
        split("", had)
        printf "    {\"%s\",\n", names[i]
        add(names[i], had)
        print "    },"
    }
    print "    {0, 0}\n};"
}
