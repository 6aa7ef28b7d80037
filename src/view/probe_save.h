/* SPDX-License-Identifier: MIT */
/* Saves captures of probes as files that `iblbake probes` takes. */
#ifndef VIEW_PROBE_SAVE_H
#define VIEW_PROBE_SAVE_H

#include <stdbool.h>
#include <stdint.h>

#include "ibl/probes.h"

/* Reads a face of a probe's capture: size x size pixels of 4 half floats, rows
 * as in cubes. False, with a message. */
typedef bool view_probe_face(void *cookie, int probe, int face, uint16_t *rgba);

typedef struct view_probe_captures {
    const ibl_probe *probe; /* layer is ignored */
    int count;              /* 1..IBL_MAX_TILE_PROBES */
    int size;               /* edge of the faces */
    int irradiance; /* edge of the irradiance cubes that the set asks for */
    view_probe_face *face;
    void *cookie;
} view_probe_captures;

/* Writes DIR/probe_NN_px.exr, _nx, _py, _ny, _pz, _nz of each probe and
 * DIR/set.json, which names the files and their sizes. Makes DIR and its
 * parents. Replaces all files or none. False, with a message. */
bool view_probe_save(ibl_ctx *ctx, const char *dir,
                     const view_probe_captures *captures);

#endif
