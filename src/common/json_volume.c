/* SPDX-License-Identifier: MIT */
#include "common/json_volume.h"

static bool take_box(const ibl_json_at *at, ibl_volume *v)
{
    static const char *const keys[] = {"centre", "half", NULL};
    const ibl_json_at centre = ibl_json_member(at, "centre");
    const ibl_json_at half = ibl_json_member(at, "half");

    v->shape = IBL_SHAPE_BOX;
    return ibl_json_object(at, keys) &&
           ibl_json_triple(&centre, -IBL_JSON_FARTHEST, IBL_JSON_FARTHEST,
                           false, v->centre) &&
           ibl_json_triple(&half, 0, IBL_JSON_FARTHEST, true, v->half);
}

static bool take_sphere(const ibl_json_at *at, ibl_volume *v)
{
    static const char *const keys[] = {"centre", "radius", NULL};
    const ibl_json_at centre = ibl_json_member(at, "centre");
    const ibl_json_at radius = ibl_json_member(at, "radius");

    v->shape = IBL_SHAPE_SPHERE;
    if (!ibl_json_object(at, keys) ||
        !ibl_json_triple(&centre, -IBL_JSON_FARTHEST, IBL_JSON_FARTHEST, false,
                         v->centre) ||
        !ibl_json_real(&radius, 0, IBL_JSON_FARTHEST, true, &v->half[0]))
        return false;
    v->half[1] = v->half[2] = v->half[0];
    return true;
}

bool ibl_json_volume(const ibl_json_at *at, ibl_volume *volume)
{
    static const char *const keys[] = {"box", "sphere", NULL};
    const ibl_json_at box = ibl_json_member(at, "box");
    const ibl_json_at sphere = ibl_json_member(at, "sphere");

    if (!ibl_json_object(at, keys))
        return false;
    if (!box.value == !sphere.value)
        return ibl_json_wrong(at, "one of box and sphere");
    return box.value ? take_box(&box, volume) : take_sphere(&sphere, volume);
}
