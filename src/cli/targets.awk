# SPDX-License-Identifier: MIT
# Of man/iblbake-engines.7 the targets (cli/targets.h) as a table of C; with
# -v readme=1 their table in README.md. What braces stand for in the programs is
# of the page's section REFLECTIONS and of include/ibl/ibl.glsl.
function member(text) { code = code (members++ ? ",\n     " : "\n    {") text }
function quoted(text, end)
{
    gsub(/[\\"]/, "\\\\&", text)
    gsub(/\n/, "\\n\"\n         \"", text)
    return "\"" text end "\""
}
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
/^\.It [a-z-]+ Ta / { bytes[$2] = $(NF - 1) }
/^\.Ss/ {
    if (targets++)
        code = code "},"
    members = blocks = 0
    member(".name = " quoted($2))
    allowed = allowed $2 ", "
    name = $2
}
/^\.Ed/ { literal = 0 }
!literal && targets && /^\.\\" / {
    word = $2
    sub(/^[^ ]* [^ ]* ?/, "")
    if (word == "readme") {
        sub(/ [|] /, sprintf(" | %.2f MB | ", bytes[name] / 1000))
        rows = rows "| " $0 " |\n"
    } else if (word == "intensity")
        member(".intensity = " $0)
    else
        member("." word " = " ($0 ? quoted($0) : "true"))
    next
}
literal && /^\.\\" (background|skybox|light|end)$/ {
    member("." $2 " =")
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
    if (/^[{]reflections /)
        $0 = reflections[substr($2, 1, length($2) - 1)]
    if (targets)
        code = code "\n         " quoted($0, "\\n")
    else
        reflections[engine] = \
            reflections[engine] (reflections[engine] ? "\n" : "") $0
}
targets && /^\.Bd -literal/ { member(blocks++ ? ".load =" : ".options =") }
/^\.Bd -literal/ { literal = 1 }
END {
    if (readme) {
        print "| `--target` | bytes | in the engine |\n| --- | --- | --- |"
        printf "%s", rows
        exit
    }
    print "/* Made by the build from man/iblbake-engines.7. */"
    print "#include <math.h>\n\n#include \"cli/targets.h\"\n"
    print "const int ibl_target_count = " targets ";"
    print "const char ibl_targets_allowed[] =\n    \"" allowed \
        "several of them with commas, all or list\";"
    print "const ibl_target ibl_targets[IBL_MAX_TARGETS] = {" code "}};"
    exit !fit
}
