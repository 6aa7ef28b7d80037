// SPDX-License-Identifier: MIT
// A model by the integral itself, over all that its surface faces: the model
// does not shade itself.
#include "model.glsl"
#include "lights.glsl"
#include "integral.glsl"

void lit(layer s, vec3 view, bool diffuse_part, uint number, out vec3 specular,
         out vec3 light)
{
    integrate(s.normal, view, s.n_v, s.f0, s.roughness, diffuse_part, number,
              specular, light);
    add_lights(at, s.normal, view, s.f0, s.roughness, sampling.w, specular,
               light);
}

#ifdef SHEEN
vec3 lit_sheen(layer s, vec3 view, vec2 sheen)
{
    return integrate_sheen(s.normal, view, s.n_v, s.roughness, 6u);
}
#endif
