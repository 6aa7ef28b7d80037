/* SPDX-License-Identifier: MIT */
#include "json/json_text.h"

#include <math.h>

/* Plus zero: JSON has no use for a negative one. */
static json_t *triple(const double v[3])
{
    return json_pack("[fff]", v[0] + 0.0, v[1] + 0.0, v[2] + 0.0);
}

json_t *ibl_lights_json(const ibl_light *lights, int count)
{
    json_t *j = json_array();

    for (int i = 0; i < count; i++) {
        const ibl_light *l = &lights[i];
        append(&j, json_pack("{so sf sf so so}", "direction",
                             triple(l->direction), "radius_rad", l->radius,
                             "radius_deg", l->radius * 180 / M_PI, "irradiance",
                             triple(l->irradiance), "radiance",
                             triple(l->radiance)));
    }
    return j;
}

/* ---- glTF ---------------------------------------------------------------- */

/* The rotation that takes +Z to a unit vector by the shortest way. */
static json_t *rotation(const double to[3])
{
    double q[4] = {-to[1], to[0], 0, 1 + to[2]};
    const double length = hypot(hypot(q[0], q[1]), q[3]);

    if (!(length > 1e-9))
        return json_pack("[ffff]", 0.0, 1.0, 0.0, 0.0);
    return json_pack("[ffff]", q[0] / length + 0.0, q[1] / length + 0.0, 0.0,
                     q[3] / length);
}

static json_t *punctual(const ibl_light *light)
{
    const double *e = light->irradiance;
    const double most = fmax(fmax(e[0], e[1]), e[2]);
    const double color[3] = {e[0] / most, e[1] / most, e[2] / most};

    return json_pack("{ss so sf}", "type", "directional", "color",
                     triple(color), "intensity", most);
}

json_t *ibl_lights_gltf(const ibl_light *lights, int count)
{
    json_t *punctuals = json_array(), *nodes = json_array();
    json_t *roots = json_array();

    for (int i = 0; i < count; i++) {
        append(&punctuals, punctual(&lights[i]));
        append(&nodes, json_pack("{so s{s{si}}}", "rotation",
                                 rotation(lights[i].direction), "extensions",
                                 "KHR_lights_punctual", "light", i));
        append(&roots, json_integer(i));
    }
    return json_pack("{s{ss ss} s[s] s{s{so}} si s[{so}] so}", "asset",
                     "version", "2.0", "generator", "iblbake " IBL_VERSION,
                     "extensionsUsed", "KHR_lights_punctual", "extensions",
                     "KHR_lights_punctual", "lights", punctuals, "scene", 0,
                     "scenes", "nodes", roots, "nodes", nodes);
}
