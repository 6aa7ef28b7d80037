# SPDX-License-Identifier: MIT
# The literal lines of man/iblbake-engines.7 to a C table (cli/targets.h): of
# each target its options, and the program in parts. What braces stand for in
# them is of that page's section REFLECTIONS and of include/ibl/ibl.glsl.
BEGIN {
    print "/* Made by the build from man/iblbake-engines.7. */"
    print "#include \"cli/targets.h\"\n"
    printf "const ibl_target_program ibl_target_programs[IBL_MAX_TARGETS] = {"
}
function part(name) { printf "%s\n     .%s =", parts++ ? "," : "", name }
FILENAME ~ /glsl$/ {
    if (/^(struct ibl_lobe |[a-z_]+ ibl_(lod|metallic|lobe_split|lobe_fit)\()/)
        wanted = 1
    sub(/ *\/\/.*/, "") # Babylon.js splits lines at semicolons
    if (wanted && NF)
        fit = fit (fit ? "\n" : "") $0
    if (/^}/)
        wanted = 0
    next
}
/^\.Ss/ {
    printf "%s\n    {", targets++ ? "}," : ""
    blocks = parts = 0
}
/^\.Ed/ { literal = 0 }
literal && /^\.\\" (background|skybox|light|end)$/ {
    part($2)
    next
}
literal && /^\.\\" reflections / {
    engine = $3
    next
}
literal {
    sub(/^\.\\" /, "")
    gsub(/\\\(aq/, "'")
    gsub(/\\\(ga/, "`")
    gsub(/\\e/, "\\")
    gsub(/env_specular\.[a-z0-9]+|env_envatlas\.png|env\.(env|gltf)/,
        "{specular}")
    gsub(/env_irradiance\.[a-z0-9]+/, "{irradiance}")
    gsub(/env_sh\.txt/, "{sh}")
    if ($0 == "{ibl_lobe_fit}")
        $0 = fit
}
literal && !targets {
    reflections[engine] = \
        reflections[engine] (reflections[engine] ? "\n" : "") $0
    next
}
literal {
    if (/^[{]reflections /)
        $0 = reflections[substr($2, 1, length($2) - 1)]
    gsub(/[\\"]/, "\\\\&")
    gsub(/\n/, "\\n\"\n         \"")
    printf "\n         \"%s\\n\"", $0
}
targets && /^\.Bd -literal/ { part(blocks++ ? "load" : "options") }
/^\.Bd -literal/ { literal = 1 }
END {
    print "}};"
    exit !fit
}
