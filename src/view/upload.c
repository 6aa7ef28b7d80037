/* SPDX-License-Identifier: MIT */
#include "view/upload.h"
#include "view/message.h"

typedef struct layout {
    GLint internal;
    GLenum format, type;
} layout;

_Static_assert(IBL_PIXEL_COUNT == 6, "each has a row below");

static const layout layouts[IBL_PIXEL_COUNT] = {
    [IBL_PIXEL_RGBA16F] = {GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT},
    [IBL_PIXEL_RGBA32F] = {GL_RGBA32F, GL_RGBA, GL_FLOAT},
    [IBL_PIXEL_RGB9E5] = {GL_RGB9_E5, GL_RGB, GL_UNSIGNED_INT_5_9_9_9_REV},
    [IBL_PIXEL_R11G11B10F] = {GL_R11F_G11F_B10F, GL_RGB,
                              GL_UNSIGNED_INT_10F_11F_11F_REV},
    [IBL_PIXEL_RG16F] = {GL_RG16F, GL_RG, GL_HALF_FLOAT},
    [IBL_PIXEL_RG32F] = {GL_RG32F, GL_RG, GL_FLOAT},
};

static int edge(int size, int level)
{
    return size >> level ? size >> level : 1;
}

static bool fits(const ibl_texture *tex, const char *name)
{
    const bool cube = tex->faces == IBL_FACES;
    GLint most = 0;

    gl.GetIntegerv(cube ? GL_MAX_CUBE_MAP_TEXTURE_SIZE : GL_MAX_TEXTURE_SIZE,
                   &most);
    if (tex->width <= most && tex->height <= most)
        return true;
    return view_fail("%s: %d x %d texels, and this OpenGL takes %d x %d at "
                     "most: bake it smaller",
                     name, tex->width, tex->height, (int)most, (int)most);
}

GLuint view_upload(const ibl_texture *tex, const char *name)
{
    const bool cube = tex->faces == IBL_FACES;
    const GLenum target = cube ? GL_TEXTURE_CUBE_MAP : GL_TEXTURE_2D;
    const layout *as = &layouts[tex->pixel];
    GLuint texture = 0;

    if (!fits(tex, name))
        return 0;
    gl.GenTextures(1, &texture);
    gl.BindTexture(target, texture);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (int level = 0; level < tex->levels; level++) {
        for (int face = 0; face < tex->faces; face++) {
            const GLenum side =
                cube ? GL_TEXTURE_CUBE_MAP_POSITIVE_X + (GLenum)face : target;
            gl.TexImage2D(side, level, as->internal, edge(tex->width, level),
                          edge(tex->height, level), 0, as->format, as->type,
                          tex->data + ibl_texture_offset(tex, level, face));
        }
    }
    view_gl_filter(target, GL_LINEAR, tex->levels);
    if (view_gl_check(name))
        return texture;
    gl.DeleteTextures(1, &texture);
    return 0;
}

GLuint view_upload_cubes(const ibl_texture *tex, const char *name)
{
    const GLenum target = GL_TEXTURE_CUBE_MAP_ARRAY;
    const layout *as = &layouts[tex->pixel];
    const GLint depth = tex->layers * IBL_FACES;
    GLuint texture = 0;
    GLint most = 0;

    if (!fits(tex, name))
        return 0;
    gl.GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most);
    if (depth > most) {
        view_fail("%s: %d cubes, and this OpenGL takes %d at most: bake fewer",
                  name, tex->layers, (int)most / IBL_FACES);
        return 0;
    }
    gl.GenTextures(1, &texture);
    gl.BindTexture(target, texture);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (int level = 0; level < tex->levels; level++)
        gl.TexImage3D(target, level, as->internal, edge(tex->width, level),
                      edge(tex->height, level), depth, 0, as->format, as->type,
                      tex->data + ibl_texture_offset(tex, level, 0));
    view_gl_filter(target, GL_LINEAR, tex->levels);
    if (view_gl_check(name))
        return texture;
    gl.DeleteTextures(1, &texture);
    return 0;
}

GLuint view_float_target(int width, int height)
{
    GLuint texture = 0;

    gl.GenTextures(1, &texture);
    gl.BindTexture(GL_TEXTURE_2D, texture);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, width, height, 0, GL_RGBA,
                  GL_FLOAT, NULL);
    view_gl_filter(GL_TEXTURE_2D, GL_NEAREST, 1);
    return texture;
}
