/* SPDX-License-Identifier: MIT */
#include "view/scene_captures.h"

#include <math.h>

#include "view/program.h"

enum {
    EDGES = 12,
    PARTS = 64 /* lines of a circle */
};

const float view_volumes_influence[3] = {0, 0.7f, 0.7f};
const float view_volumes_proxy[3] = {0.7f, 0, 0.7f};

bool view_volumes_render(GLuint *program, double ev, const ibl_volume *volume,
                         const float colour[3])
{
    const bool sphere = volume->shape == IBL_SHAPE_SPHERE;
    const double *c = volume->centre, *half = volume->half;
    const float scale = (float)exp2(-ev);

    if (!*program)
        *program = view_program("volume.vert", "volume.frag");
    if (!*program)
        return false;
    gl.Disable(GL_BLEND);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LEQUAL);
    gl.DepthMask(GL_FALSE);
    gl.VertexAttrib4f(1, (float)c[0], (float)c[1], (float)c[2],
                      sphere ? PARTS : 0);
    gl.VertexAttrib4f(2, (float)half[0], (float)half[sphere ? 0 : 1],
                      (float)half[sphere ? 0 : 2], 1);
    gl.VertexAttrib4f(3, scale * colour[0], scale * colour[1],
                      scale * colour[2], 1);
    view_gl_draw(*program, GL_LINES, 2 * (sphere ? 3 * PARTS : EDGES));
    gl.DepthMask(GL_TRUE);
    gl.DepthFunc(GL_LESS);
    gl.Disable(GL_DEPTH_TEST);
    return true;
}
