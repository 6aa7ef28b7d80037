/* SPDX-License-Identifier: MIT */
#include "ibl/ibl.h"

const char *ibl_lobe_name(ibl_lobe lobe)
{
    static const char *const names[] = {"ggx", "charlie", "phong"};
    return names[lobe >= IBL_LOBE_GGX && lobe <= IBL_LOBE_PHONG ? lobe : 0];
}
