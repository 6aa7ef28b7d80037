/* SPDX-License-Identifier: MIT */
#include "view/upload.h"
#include "view/message.h"
#include "view/program.h"

enum {
    MOST_COLUMNS = 8192 /* of a map as a backdrop: 400 MB */
};

static bool fits(const ibl_texture *tex, GLenum target, const char *name)
{
    GLint most = 0, layers = 0;

    gl.GetIntegerv(tex->faces == 1 ? GL_MAX_TEXTURE_SIZE
                                   : GL_MAX_CUBE_MAP_TEXTURE_SIZE,
                   &most);
    if (tex->width > most || tex->height > most)
        return view_fail("%s: %d x %d texels, and this OpenGL takes %d x %d at "
                         "most: bake it smaller",
                         name, tex->width, tex->height, (int)most, (int)most);
    gl.GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &layers);
    return target != GL_TEXTURE_CUBE_MAP_ARRAY ||
           tex->layers * IBL_FACES <= layers ||
           view_fail("%s: %d cubes, and this OpenGL takes %d at most: bake "
                     "fewer",
                     name, tex->layers, (int)layers / IBL_FACES);
}

static void upload_level(const ibl_texture *tex, GLenum target, int level)
{
    const ibl_pixel_numbers as = ibl_pixel_numbers_of(tex->pixel);
    const GLint internal = (GLint)as.gl_internal;
    const int width = ibl_cube_edge(tex->width, level);
    const int height = ibl_cube_edge(tex->height, level);

    if (target == GL_TEXTURE_CUBE_MAP_ARRAY || target == GL_TEXTURE_2D_ARRAY)
        gl.TexImage3D(target, level, internal, width, height,
                      tex->layers * tex->faces, 0, as.gl_format, as.gl_type,
                      tex->data + ibl_texture_offset(tex, level, 0));
    else
        for (int face = 0; face < tex->faces; face++)
            gl.TexImage2D(target == GL_TEXTURE_2D
                              ? target
                              : GL_TEXTURE_CUBE_MAP_POSITIVE_X + (GLenum)face,
                          level, internal, width, height, 0, as.gl_format,
                          as.gl_type,
                          tex->data + ibl_texture_offset(tex, level, face));
}

GLuint view_upload(const ibl_texture *tex, bool cubes, const char *name)
{
    const GLenum target = cubes                     ? GL_TEXTURE_CUBE_MAP_ARRAY
                          : tex->faces == IBL_FACES ? GL_TEXTURE_CUBE_MAP
                          : tex->layers > 1         ? GL_TEXTURE_2D_ARRAY
                                                    : GL_TEXTURE_2D;
    GLuint texture = 0;

    if (!fits(tex, target, name))
        return 0;
    gl.GenTextures(1, &texture);
    gl.BindTexture(target, texture);
    for (int level = 0; level < tex->levels; level++)
        upload_level(tex, target, level);
    view_gl_filter(target, GL_LINEAR, tex->levels);
    if (view_gl_check(name))
        return texture;
    gl.DeleteTextures(1, &texture);
    return 0;
}

GLuint view_upload_map(const baked_set *set)
{
    GLint most = 0;
    GLuint texture = 0;
    ibl_image map;

    gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    if (!view_set_map(set, &map))
        return 0;
    if (map.width <= most && map.width <= MOST_COLUMNS) {
        texture = view_float_image(GL_RGB, map.width, map.height, map.data);
        view_gl_filter(GL_TEXTURE_2D, GL_LINEAR, 1);
        gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
    }
    ibl_image_free(&map);
    return texture;
}

GLuint view_float_image(GLenum format, int width, int height,
                        const float *pixels)
{
    const GLint internal = format == GL_RGB ? GL_RGB32F : GL_RGBA32F;
    GLuint texture = 0;

    gl.GenTextures(1, &texture);
    gl.BindTexture(GL_TEXTURE_2D, texture);
    gl.TexImage2D(GL_TEXTURE_2D, 0, internal, width, height, 0, format,
                  GL_FLOAT, pixels);
    view_gl_filter(GL_TEXTURE_2D, GL_NEAREST, 1);
    return texture;
}

void view_image_free(view_image *i)
{
    gl.DeleteFramebuffers(1, &i->framebuffer);
    gl.DeleteTextures(1, &i->texture);
    *i = (view_image){0};
}

bool view_image_make(view_image *i, int width, int height)
{
    if (i->width == width && i->height == height)
        return true;
    view_image_free(i);
    gl.ActiveTexture(GL_TEXTURE0 + VIEW_UNIT_PICTURE);
    i->texture = view_float_image(GL_RGBA, width, height, NULL);
    gl.GenFramebuffers(1, &i->framebuffer);
    if (!view_gl_target(i->framebuffer, i->texture))
        return view_fail("this OpenGL cannot draw into a picture of %d x %d "
                         "floats: ask for a smaller one",
                         width, height);
    i->width = width;
    i->height = height;
    return view_gl_check("making a picture");
}

bool view_mean_make(view_mean *m)
{
    m->program = view_program("full.vert", "mean.frag");
    m->part = m->program ? gl.GetUniformLocation(m->program, "part") : 0;
    return m->program;
}

bool view_mean_add(const view_mean *m, const view_image *picture, float part,
                   view_image *mean)
{
    const int width = picture->width, height = picture->height;

    if (!view_image_make(mean, width, height))
        return false;
    gl.BindFramebuffer(GL_FRAMEBUFFER, mean->framebuffer);
    if (part >= 1) { /* with its alpha; the mean may hold NaN */
        gl.BindFramebuffer(GL_READ_FRAMEBUFFER, picture->framebuffer);
        gl.BlitFramebuffer(0, 0, width, height, 0, 0, width, height,
                           GL_COLOR_BUFFER_BIT, GL_NEAREST);
        return true;
    }
    gl.Viewport(0, 0, width, height);
    view_gl_bind(VIEW_UNIT_PICTURE, GL_TEXTURE_2D, picture->texture);
    gl.UseProgram(m->program);
    gl.Uniform1f(m->part, part);
    gl.Enable(GL_BLEND);
    view_gl_draw_full(m->program);
    gl.Disable(GL_BLEND);
    return true;
}
