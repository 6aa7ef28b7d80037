/* SPDX-License-Identifier: MIT */
/* Chooses the outputs of fewest bytes whose rendered error, as measured, is at
 * most that of --rendered-error. */
#ifndef CLI_CHOOSE_H
#define CLI_CHOOSE_H

#include "cli/job.h"
#include "cli/rendered.h"

/* All roughnesses and both F0 in equal parts; F0 = .04 has an albedo of .18. */
ibl_materials ibl_materials_all(void);

/*
 * Chooses size, levels and their roughnesses, pixel format, irradiance or
 * harmonics and the sizes of the tables, other than those that the user or the
 * target fixed, and changes the options accordingly. If the error cannot be
 * reached, the set is that of fewest bytes within 1.3 times the least, above .5
 * within .3 of what the least lacks to 1, and the options stay as they are
 * where no set is as good. Without --rendered-error, as of a scene, there are
 * no more bytes than the default's. False after a message.
 *   from  its environment was read
 */
bool ibl_choose(const ibl_job *from, const ibl_materials *materials,
                ibl_opts *o, ibl_choice *choice);

/* Whether sheen needs a set of its own beside o; sets its options, which are
 * those of o, chosen or not, for Charlie's lobe. */
bool ibl_scenes_sheen(const ibl_scenes *s, const ibl_opts *o, ibl_opts *sheen,
                      ibl_choice *choice);

#endif
