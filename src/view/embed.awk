# SPDX-License-Identifier: MIT
# Shader files to a C table of names and texts (view/program.h), a string for
# each line.
BEGIN {
    print "/* Made by the build from src/view/shaders. */"
    print "#include \"view/program.h\"\n"
    print "const view_shader_file view_shader_files[] = {"
}
FNR == 1 {
    if (NR > 1)
        print "    },"
    name = FILENAME
    sub(/.*\//, "", name)
    printf "    {\n        \"%s\",\n", name
}
{
    gsub(/\\/, "\\\\")
    gsub(/"/, "\\\"")
    printf "        \"%s\\n\"\n", $0
}
END {
    if (NR)
        print "    },"
    print "    {0, 0}\n};"
}
