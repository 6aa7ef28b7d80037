# SPDX-License-Identifier: MIT
# Completion of iblbake and iblview, which know their options themselves.
_iblbake()
{
    local IFS=$'\n' word=${COMP_WORDS[COMP_CWORD]}
    # shellcheck disable=SC2207
    COMPREPLY=($(compgen -W "$("${COMP_WORDS[0]}" --complete \
        "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null | cut -f 1)" -- "$word"))
}
complete -o default -F _iblbake iblbake iblview
