# SPDX-License-Identifier: MIT
# The literal lines of man/iblbake-engines.7 to a C table (cli/targets.h): of
# each target its options, and the program in parts.
BEGIN {
    print "/* Made by the build from man/iblbake-engines.7. */"
    print "#include \"cli/targets.h\"\n"
    printf "const ibl_target_program ibl_target_programs[IBL_MAX_TARGETS] = {"
}
function part(name) { printf "%s\n     .%s =", parts++ ? "," : "", name }
/^\.Ss/ {
    printf "%s\n    {", targets++ ? "}," : ""
    blocks = parts = 0
}
/^\.Ed/ { literal = 0 }
literal && /^\.\\" (background|skybox|light|end)$/ {
    part($2)
    next
}
literal {
    sub(/^\.\\" /, "")
    gsub(/\\\(aq/, "'")
    gsub(/\\e/, "\\")
    gsub(/env_specular\.[a-z0-9]+|env_envatlas\.png|env\.(env|gltf)/,
        "{specular}")
    gsub(/env_irradiance\.[a-z0-9]+/, "{irradiance}")
    gsub(/env_sh\.txt/, "{sh}")
    gsub(/[\\"]/, "\\\\&")
    printf "\n         \"%s\\n\"", $0
}
targets && /^\.Bd -literal/ {
    literal = 1
    part(blocks++ ? "load" : "options")
}
END { print "}};" }
