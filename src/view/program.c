/* SPDX-License-Identifier: MIT */
#include "view/program.h"

#include "view/message.h"
#include <string.h>

enum {
    LOG_BYTES = 4096
};

/* NULL, with a message. */
static const view_shader_file *find_file(const view_shader_file *files,
                                         const char *name)
{
    for (; files->name; files++)
        if (!strcmp(files->name, name))
            return files;
    view_fail("shader %s is not in the program", name);
    return NULL;
}

/* The first line with an error rather than a warning; else the first. */
static const char *log_line(const char *log)
{
    const char *line = strstr(log, "rror");

    while (line && line > log && line[-1] != '\n')
        line--;
    return line ? line : log;
}

static GLuint compile(const view_shader_file *files, const char *defines,
                      GLenum kind, const char *name)
{
    const view_shader_file *file = find_file(files, name);
    const char *text[VIEW_SHADER_PARTS + 2] = {
        "#version 330 core\n"
        "#extension GL_ARB_texture_cube_map_array : enable\n",
        defines};
    int count = 2;
    GLint ok = 0;

    if (!file)
        return 0;
    for (int i = 0; i < VIEW_SHADER_PARTS && file->text[i]; i++)
        text[count++] = file->text[i];
    const GLuint shader = gl.CreateShader(kind);
    gl.ShaderSource(shader, count, text, NULL);
    gl.CompileShader(shader);
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (!ok) {
        char log[LOG_BYTES] = "the compiler does not say why";
        gl.GetShaderInfoLog(shader, sizeof log, NULL, log);
        const char *line = log_line(log);
        view_fail("shader %s: %.*s", name, (int)strcspn(line, "\n"), line);
        gl.DeleteShader(shader);
    }
    return ok ? shader : 0;
}

static GLuint link_program(GLuint vertex, GLuint fragment, const char *name)
{
    const GLuint program = gl.CreateProgram();
    GLint ok = 0;

    gl.AttachShader(program, vertex);
    gl.AttachShader(program, fragment);
    gl.LinkProgram(program);
    gl.DetachShader(program, vertex);
    gl.DetachShader(program, fragment);
    gl.GetProgramiv(program, GL_LINK_STATUS, &ok);
    if (ok)
        return program;
    char log[LOG_BYTES] = "the linker does not say why";
    gl.GetProgramInfoLog(program, sizeof log, NULL, log);
    view_fail("shader %s: %.*s", name, (int)strcspn(log, "\n"), log);
    gl.DeleteProgram(program);
    return 0;
}

/* Binds uniform blocks and samplers, which never changes. */
static void bind(GLuint program)
{
    static const char *const blocks[] = {
        [VIEW_BLOCK_FRAME] = "Frame",
        [VIEW_BLOCK_ROOM] = "Room",
        [VIEW_BLOCK_MATERIAL] = "Material",
    };
    static const struct {
        const char *name;
        int unit;
    } samplers[] = {
        {"specular_map", VIEW_UNIT_SPECULAR},
        {"irradiance_map", VIEW_UNIT_IRRADIANCE},
        {"lut_map", VIEW_UNIT_LUT},
        {"sky_map", VIEW_UNIT_SKY},
        {"backdrop_map", VIEW_UNIT_OTHER},
        {"picture", VIEW_UNIT_PICTURE},
        {"other", VIEW_UNIT_OTHER},
        {"lobe_map", VIEW_UNIT_LOBES},
        {"sheen_chain", VIEW_UNIT_SHEEN},
        {"sheen_table", VIEW_UNIT_SHEEN_TABLE},
        {"environment_map", VIEW_TRUTH_UNIT_MAP},
        {"aim_tokens", VIEW_TRUTH_UNIT_TOKENS},
        {"aim_chance", VIEW_TRUTH_UNIT_CHANCE},
        {"dynamic_specular", VIEW_ROOM_UNIT_DYNAMIC},
        {"dynamic_irradiance", VIEW_ROOM_UNIT_DYNAMIC + 1},
        {"local_specular", VIEW_ROOM_UNIT_LOCALS},
        {"local_irradiance", VIEW_ROOM_UNIT_LOCALS + 1},
        {"probe_buffer", VIEW_ROOM_UNIT_BUFFER},
        {"tile_masks", VIEW_ROOM_UNIT_MASKS},
        {"source", VIEW_CAPTURE_UNIT},
        {"source1", VIEW_CAPTURE_UNIT_MORE},
        {"samples", VIEW_CAPTURE_UNIT_MORE},
    };

    for (GLuint i = 0; i < sizeof blocks / sizeof *blocks; i++) {
        const GLuint block = gl.GetUniformBlockIndex(program, blocks[i]);
        if (block != GL_INVALID_INDEX)
            gl.UniformBlockBinding(program, block, i);
    }
    gl.UseProgram(program);
    for (size_t i = 0; i < sizeof samplers / sizeof *samplers; i++) {
        const GLint at = gl.GetUniformLocation(program, samplers[i].name);
        if (at >= 0)
            gl.Uniform1i(at, samplers[i].unit);
    }
    gl.UseProgram(0);
}

GLuint view_program_from(const view_shader_file *files, const char *defines,
                         const char *vertex_file, const char *fragment_file)
{
    const GLuint vertex =
        compile(files, defines, GL_VERTEX_SHADER, vertex_file);
    const GLuint fragment =
        vertex ? compile(files, defines, GL_FRAGMENT_SHADER, fragment_file) : 0;
    GLuint program = 0;

    if (fragment)
        program = link_program(vertex, fragment, fragment_file);
    if (program)
        bind(program);
    gl.DeleteShader(vertex);
    gl.DeleteShader(fragment);
    return program;
}

GLuint view_program(const char *vertex_file, const char *fragment_file)
{
    return view_program_from(view_shader_files, "", vertex_file, fragment_file);
}
