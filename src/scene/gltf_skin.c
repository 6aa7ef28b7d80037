/* SPDX-License-Identifier: MIT */
/* Skins of glTF, section 3.7.3: vertices are moved once, by the pose that the
 * nodes have in the file. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"
#include "core/alloc.h"
#include "scene/gltf_reader.h"

/* Matrices of joints, by columns: from the vertices to the world. */
typedef struct joints {
    double (*matrix)[16];
    int count;
} joints;

/* World of the node times inverse bind. */
static bool read_joints(ibl_gltf *g, ibl_json_at skin,
                        const double (*world)[16], int nodes, joints *j)
{
    const ibl_json_at list = ibl_json_member(&skin, "joints");
    const ibl_json_at bind = ibl_json_member(&skin, "inverseBindMatrices");
    float *inverse = NULL;
    uint32_t count = 0;

    if (!ibl_json_array(list, 1, 1 << 20) ||
        !ibl_gltf_count(g, list, 64 * json_array_size(list.value)))
        return false;
    j->count = (int)json_array_size(list.value);
    j->matrix = ibl_need(malloc((size_t)j->count * sizeof *j->matrix));
    bool ok = !bind.value || ibl_gltf_floats(g, bind, 16, 16, &inverse, &count);
    if (ok && bind.value && count < (uint32_t)j->count)
        ok = ibl_json_complain(bind, "damaged: %u matrices for %d joints",
                               count, j->count);
    for (int i = 0; i < j->count && ok; i++) {
        int node;
        ok = ibl_gltf_index(ibl_json_element(&list, (size_t)i), nodes, &node);
        for (int k = 0; k < 16 && ok; k++) {
            j->matrix[i][k] = inverse ? 0 : world[node][k];
            for (int c = 0; c < 4 && inverse; c++)
                j->matrix[i][k] += world[node][k % 4 + 4 * c] *
                                   (double)inverse[16 * i + k / 4 * 4 + c];
        }
    }
    ibl_free(inverse);
    return ok;
}

/* The mean of the joints' matrices that move a vertex. */
static void blend(const joints *j, const ibl_scene_primitive *p, size_t vertex,
                  double m[16])
{
    double sum = 0;

    memset(m, 0, 16 * sizeof *m);
    for (size_t i = 0; i < 4 * IBL_SCENE_JOINTS; i++) {
        if (!p->joints[i / 4] || !p->weights[i / 4])
            continue;
        const double weight = (double)p->weights[i / 4][4 * vertex + i % 4];
        const float joint = p->joints[i / 4][4 * vertex + i % 4];
        if (weight == 0 || !(joint >= 0 && joint < (float)j->count))
            continue;
        for (int k = 0; k < 16; k++)
            m[k] += weight * j->matrix[(int)joint][k];
        sum += weight;
    }
    for (int k = 0; k < 16; k++)
        m[k] = sum > 0 ? m[k] / sum : j->matrix[0][k];
}

static void normalise(const double v[3], float to[3])
{
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);

    for (int k = 0; k < 3 && length > 0; k++)
        to[k] = (float)(v[k] / length);
}

/* Moves a vertex. Returns the sign of the matrix's determinant: normals turn
 * with the cofactors, which are the inverse transposed but for a factor. */
static double move(const joints *j, ibl_scene_primitive *p, size_t vertex,
                   const double origin[3])
{
    float *position = p->position + 3 * vertex,
          *normal = p->normal + 3 * vertex;
    float *tangent = p->tangent ? p->tangent + 4 * vertex : NULL;
    double m[16], at[3], n[3], t[3], cofactor[3][3];

    blend(j, p, vertex, m);
    for (int c = 0; c < 3; c++)
        for (int r = 0; r < 3; r++) {
            const double *a = m + (c + 1) % 3 * 4, *b = m + (c + 2) % 3 * 4;
            cofactor[c][r] = a[(r + 1) % 3] * b[(r + 2) % 3] -
                             a[(r + 2) % 3] * b[(r + 1) % 3];
        }
    const double sign =
        m[0] * cofactor[0][0] + m[1] * cofactor[0][1] + m[2] * cofactor[0][2] <
                0
            ? -1
            : 1;
    for (int r = 0; r < 3; r++) {
        at[r] = m[12 + r] - origin[r];
        n[r] = t[r] = 0;
        for (int c = 0; c < 3; c++) {
            at[r] += m[4 * c + r] * (double)position[c];
            n[r] += sign * cofactor[c][r] * (double)normal[c];
            t[r] += m[4 * c + r] * (double)(tangent ? tangent[c] : 0);
        }
    }
    for (int r = 0; r < 3; r++)
        position[r] = (float)at[r];
    normalise(n, normal);
    if (tangent) {
        normalise(t, tangent);
        tangent[3] *= (float)sign;
    }
    return sign;
}

/* Moves a primitive, which then needs its joints no longer. False: nothing is
 * left of it. */
static bool move_all(ibl_gltf *g, const joints *j, ibl_scene_primitive *p,
                     const double origin[3])
{
    double sign = 0;

    for (size_t v = 0; v < p->vertex_count; v++)
        sign += move(j, p, v, origin);
    /* A mirror image shows its other side. */
    for (uint32_t i = 0; i < p->index_count && sign < 0; i += 3) {
        const uint32_t second = p->index[i + 1];
        p->index[i + 1] = p->index[i + 2];
        p->index[i + 2] = second;
    }
    for (int k = 0; k < IBL_SCENE_JOINTS; k++) {
        ibl_free(p->joints[k]);
        ibl_free(p->weights[k]);
        p->joints[k] = p->weights[k] = NULL;
    }
    return ibl_gltf_drop_nowhere(g, p);
}

bool ibl_gltf_skin(ibl_gltf *g, ibl_json_at index, const double (*world)[16],
                   int nodes, int first, double origin[3])
{
    ibl_scene *s = g->scene;
    ibl_json_at skins;
    const int count = ibl_gltf_array(g, "skins", &skins);
    joints j = {0};
    int i, kept = first;

    const bool ok =
        ibl_gltf_index(index, count, &i) &&
        read_joints(g, ibl_json_element(&skins, (size_t)i), world, nodes, &j);
    /* Floats stay exact far from the world's origin. */
    for (int k = 0; k < 3 && ok; k++)
        origin[k] = isfinite(j.matrix[0][12 + k]) ? j.matrix[0][12 + k] : 0;
    for (i = first; i < s->primitive_count; i++)
        if (ok && move_all(g, &j, &s->primitives[i], origin))
            s->primitives[kept++] = s->primitives[i];
        else
            ibl_scene_primitive_free(&s->primitives[i]);
    s->primitive_count = kept;
    free(j.matrix);
    return ok;
}
