# SPDX-License-Identifier: MIT
# Completion of iblbake and iblview, which know their options themselves.
for program in iblbake iblview
    complete -c $program -a "($program --complete \
        (commandline -opc)[2..] (commandline -ct) 2>/dev/null)"
end
