/* SPDX-License-Identifier: MIT */
/* Chooses the outputs of fewest bytes whose expected rendered error is at most
 * that of --rendered-error. */
#ifndef CLI_CHOOSE_H
#define CLI_CHOOSE_H

#include "cli/bake_record.h"
#include "cli/choice.h"

/*
 * Chooses size, levels, mapping, pixel format, irradiance or harmonics and the
 * sizes of the tables, other than those that the user or the target fixed, and
 * changes the options accordingly. If the error cannot be reached, the set is
 * that of fewest bytes within 1.2 times the least error, in which format,
 * irradiance and BRDF table add no more than the error that was asked or, if
 * that is more, than the finest do. Without --rendered-error, as of a scene,
 * there are no more bytes than the default's.
 *   from  its environment was read
 */
bool ibl_choose(ibl_bake_source *from, const ibl_materials *materials,
                ibl_opts *o, ibl_choice *choice);

#endif
