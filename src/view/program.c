/* SPDX-License-Identifier: MIT */
#include "view/program.h"

#include "view/message.h"
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    MAX_FILES = 64,
    LOG_BYTES = 4096
};

/* Where a stretch of lines is from. */
typedef struct stretch {
    int begin;      /* line of the text */
    int file, line; /* of the table, and its line */
} stretch;

/* A shader with its includes, as the compiler sees it. Lines are counted here,
 * since Mesa forgets the file number of #line in most errors. */
typedef struct source {
    const view_shader_file *files;
    bool had[MAX_FILES];
    char *text; /* NULL after an error */
    size_t size, room;
    int lines;
    stretch from[2 * MAX_FILES]; /* a file begins, or goes on after another */
    int count;
} source;

/* ---- including ------------------------------------------------------- */

/* Adds a line, without its end. */
static bool append(source *s, const char *line, size_t size)
{
    if (s->room - s->size < size + 2) {
        const size_t room = 2 * (s->room + size) + 1024;
        char *grown = realloc(s->text, room);
        if (!grown)
            return view_fail("no memory for the shaders");
        s->text = grown;
        s->room = room;
    }
    memcpy(s->text + s->size, line, size);
    memcpy(s->text + s->size + size, "\n", 2);
    s->size += size + 1;
    s->lines++;
    return true;
}

static void mark(source *s, int file, int line)
{
    s->from[s->count++] = (stretch){s->lines + 1, file, line};
}

static int find_file(const view_shader_file *files, const char *name, size_t n)
{
    for (int i = 0; files[i].name && i < MAX_FILES; i++)
        if (strlen(files[i].name) == n && !memcmp(files[i].name, name, n))
            return i;
    return -1;
}

/* The name between the quotes of an #include line. */
static bool is_include(const char *line, const char **name, size_t *size)
{
    static const char word[] = "#include \"";

    if (strncmp(line, word, sizeof word - 1) != 0)
        return false;
    *name = line + sizeof word - 1;
    *size = strcspn(*name, "\"\n");
    return (*name)[*size] == '"';
}

/* Adds a file; each only once, which ends every circle. */
static bool include(source *s, int file)
{
    const char *line = s->files[file].text;

    s->had[file] = true;
    mark(s, file, 1);
    for (int number = 1; *line; number++) {
        const char *name;
        size_t name_size;
        const size_t size = strcspn(line, "\n");
        const bool wants = is_include(line, &name, &name_size);
        const int other = wants ? find_file(s->files, name, name_size) : -1;
        if (wants && other < 0)
            return view_fail("shader %s:%d includes %.*s, which is not in the "
                             "program",
                             s->files[file].name, number, (int)name_size, name);
        if (wants && !s->had[other]) {
            if (!include(s, other))
                return false;
            mark(s, file, number + 1);
        } else if (!append(s, line, wants ? 0 : size)) {
            return false;
        }
        line += size + (line[size] == '\n');
    }
    return true;
}

/* s->text is the caller's to free. */
static bool load(source *s, const char *name)
{
    static const char head[] = "#version 330 core";
    const int file = find_file(s->files, name, strlen(name));

    if (file < 0)
        return view_fail("shader %s is not in the program", name);
    return append(s, head, sizeof head - 1) && include(s, file);
}

/* ---- what compilers say ---------------------------------------------- */

/* The line that a line of a log is about: "0:23(4): error" (Mesa), "0(23) :
 * error" (NVIDIA), "ERROR: 0:23: ..." (others); 0: none. *rest: what
 * follows. */
static int log_place(const char *log, const char **rest)
{
    for (const char *c = log; *c && *c != '\n'; c++) {
        int number = 0, used = 0;
        if (c[0] != '0' || (c > log && isalnum((unsigned char)c[-1])))
            continue;
        if (sscanf(c, "0:%d%n", &number, &used) != 1 &&
            sscanf(c, "0(%d)%n", &number, &used) != 1)
            continue;
        *rest = c + used;
        if (**rest == '(')
            *rest += strcspn(*rest, ")\n") + 1;
        *rest += strspn(*rest, " :");
        return number;
    }
    return 0;
}

/* The first line that tells of an error, not of a warning; else the first. */
static const char *log_line(const char *log)
{
    const char *line = log;

    while (*line) {
        const size_t size = strcspn(line, "\n");
        const char *error = strstr(line, "rror");
        if (error && error < line + size)
            return line;
        line += size + (line[size] == '\n');
    }
    return log;
}

static void tell(const source *s, const char *name, const char *log)
{
    const char *line = log_line(log), *rest = line;
    const int number = log_place(line, &rest);
    const stretch *at = NULL;

    for (int i = 0; i < s->count && s->from[i].begin <= number; i++)
        at = &s->from[i];
    if (at)
        view_fail("shader %s: %s:%d: %.*s", name, s->files[at->file].name,
                  at->line + number - at->begin, (int)strcspn(rest, "\n"),
                  rest);
    else
        view_fail("shader %s: %.*s", name, (int)strcspn(line, "\n"), line);
}

/* ---- programs -------------------------------------------------------- */

static GLuint compile(const view_shader_file *files, GLenum kind,
                      const char *name)
{
    source s = {.files = files};
    GLuint shader = 0;
    GLint ok = 0;

    if (load(&s, name)) {
        shader = gl.CreateShader(kind);
        gl.ShaderSource(shader, 1, (const GLchar *const *)&s.text, NULL);
        gl.CompileShader(shader);
        gl.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
        if (!ok) {
            char log[LOG_BYTES] = "the compiler does not say why";
            gl.GetShaderInfoLog(shader, sizeof log, NULL, log);
            tell(&s, name, log);
            gl.DeleteShader(shader);
            shader = 0;
        }
    }
    free(s.text);
    return shader;
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

/* Gives blocks and samplers their places, once for all. */
static void bind(GLuint program)
{
    static const char *const blocks[] = {
        [VIEW_BLOCK_FRAME] = "Frame",
        [VIEW_BLOCK_ROOM] = "Room",
        [VIEW_BLOCK_SUN] = "Sun",
    };
    static const struct {
        const char *name;
        int unit;
    } samplers[] = {
        {"specular_map", VIEW_UNIT_SPECULAR},
        {"irradiance_map", VIEW_UNIT_IRRADIANCE},
        {"lut_map", VIEW_UNIT_LUT},
        {"sky_map", VIEW_UNIT_SKY},
        {"picture", VIEW_UNIT_PICTURE},
        {"truth", VIEW_UNIT_TRUTH},
        {"pass_picture", VIEW_TRUTH_UNIT_PASS},
        {"aim_tokens", VIEW_TRUTH_UNIT_TOKENS},
        {"aim_chance", VIEW_TRUTH_UNIT_CHANCE},
        {"dynamic_specular", VIEW_ROOM_UNIT_DYNAMIC},
        {"dynamic_irradiance", VIEW_ROOM_UNIT_DYNAMIC + 1},
        {"local_specular", VIEW_ROOM_UNIT_LOCALS},
        {"local_irradiance", VIEW_ROOM_UNIT_LOCALS + 1},
        {"probe_buffer", VIEW_ROOM_UNIT_BUFFER},
        {"tile_masks", VIEW_ROOM_UNIT_MASKS},
        {"sun_depth", VIEW_ROOM_UNIT_SHADOW},
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

GLuint view_program_from(const view_shader_file *files, const char *vertex_file,
                         const char *fragment_file)
{
    const GLuint vertex = compile(files, GL_VERTEX_SHADER, vertex_file);
    const GLuint fragment =
        vertex ? compile(files, GL_FRAGMENT_SHADER, fragment_file) : 0;
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
    return view_program_from(view_shader_files, vertex_file, fragment_file);
}
