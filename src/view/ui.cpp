// SPDX-License-Identifier: MIT
#include <cerrno>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <backends/imgui_impl_glfw.h>
#include <imgui.h>

extern "C" {
#include "common/signals.h"
#include "view/app.h"
#include "view/gl.h"
#include "view/message.h"
#include "view/ui.h"
}

namespace
{

const char font_file[] = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
const float text_units = 14;
// Textures of draw lists besides the font's: ui.frag draws them.
enum {
    letters,
    false_colours,
    greys
};

struct {
    GLuint program, array, vertices, indices, font;
    GLint window, kind;
    float scale;
    int width, height;
    bool attached;
} ui;

ImU32 colour_of(unsigned rgb, unsigned alpha = 255)
{
    return IM_COL32(rgb >> 16 & 255, rgb >> 8 & 255, rgb & 255, alpha);
}

ImDrawList *page()
{
    return ImGui::GetBackgroundDrawList();
}

// ---- OpenGL ----------------------------------------------------------------

// ImGui does not look at what it is given.
void *need_bytes(size_t size, void *)
{
    return ibl_need(malloc(size));
}

void free_bytes(void *p, void *)
{
    free(p);
}

// ImGui ends the program where it fails to read a file.
bool add_font(float size)
{
    ImFontAtlas *fonts = ImGui::GetIO().Fonts;
    FILE *file = fopen(font_file, "rb");
    ImFontConfig own;

    own.SizePixels = size;
    if (!file)
        return fonts->AddFontDefault(&own);
    fseek(file, 0, SEEK_END);
    const long bytes = ftell(file);
    rewind(file);
    void *font = ImGui::MemAlloc(bytes > 0 ? (size_t)bytes : 1);
    const bool all =
        bytes > 0 && fread(font, 1, (size_t)bytes, file) == (size_t)bytes;
    const int why = ferror(file) ? errno : EINVAL;
    fclose(file);
    if (all) // freed with the others
        return fonts->AddFontFromMemoryTTF(font, (int)bytes, size);
    ImGui::MemFree(font);
    return view_fail("%s: %s: install package fonts-dejavu-core again",
                     font_file, strerror(why));
}

bool make_font()
{
    ImGuiIO &io = ImGui::GetIO();
    unsigned char *pixels = nullptr;
    int width = 0, height = 0;

    if (!add_font(floorf(text_units * ui.scale + 0.5F)))
        return false;
    io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
    gl.GenTextures(1, &ui.font);
    view_gl_bind(VIEW_UNIT_PICTURE, GL_TEXTURE_2D, ui.font);
    view_gl_filter(GL_TEXTURE_2D, GL_LINEAR, 1);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA,
                  GL_UNSIGNED_BYTE, pixels);
    io.Fonts->SetTexID((ImTextureID)(intptr_t)letters);
    return true;
}

void attribute(GLuint at, int size, GLenum type, size_t offset)
{
    gl.EnableVertexAttribArray(at);
    gl.VertexAttribPointer(at, size, type, type == GL_UNSIGNED_BYTE,
                           sizeof(ImDrawVert), (const void *)offset);
}

void make_arrays()
{
    gl.GenVertexArrays(1, &ui.array);
    gl.BindVertexArray(ui.array);
    ui.vertices = view_gl_buffer(GL_ARRAY_BUFFER, 0, nullptr);
    ui.indices = view_gl_buffer(GL_ELEMENT_ARRAY_BUFFER, 0, nullptr);
    attribute(0, 2, GL_FLOAT, offsetof(ImDrawVert, pos));
    attribute(1, 2, GL_FLOAT, offsetof(ImDrawVert, uv));
    attribute(2, 4, GL_UNSIGNED_BYTE, offsetof(ImDrawVert, col));
    gl.BindVertexArray(0);
}

void draw_list(const ImDrawList *list)
{
    size_t offset = 0;

    gl.BufferData(GL_ARRAY_BUFFER, list->VtxBuffer.size_in_bytes(),
                  list->VtxBuffer.Data, GL_STREAM_DRAW);
    gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, list->IdxBuffer.size_in_bytes(),
                  list->IdxBuffer.Data, GL_STREAM_DRAW);
    for (const ImDrawCmd &c : list->CmdBuffer) {
        const ImVec4 &clip = c.ClipRect;
        gl.Scissor((GLint)clip.x, (GLint)((float)ui.height - clip.w),
                   (GLsizei)fmaxf(clip.z - clip.x, 0),
                   (GLsizei)fmaxf(clip.w - clip.y, 0));
        gl.Uniform1i(ui.kind, (GLint)(intptr_t)c.TextureId);
        gl.DrawElements(GL_TRIANGLES, (GLsizei)c.ElemCount, GL_UNSIGNED_SHORT,
                        (const void *)(offset * sizeof(ImDrawIdx)));
        offset += c.ElemCount;
    }
}

// ---- controls --------------------------------------------------------------

// Below a control that is greyed.
void say_why(const char *why)
{
    if (why && ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
        ImGui::SetTooltip("%s", why);
}

bool show_choice(const char *label, int *value, const char *const *names)
{
    bool changed = false;

    if (!ImGui::BeginCombo(label, names[*value]))
        return false;
    for (int i = 0; names[i]; i++)
        if (ImGui::Selectable(names[i], i == *value)) {
            *value = i;
            changed = true;
        }
    ImGui::EndCombo();
    return changed;
}

bool show_doubled(const char *label, int *value, int least, int most)
{
    char text[16];
    bool changed = false;

    snprintf(text, sizeof text, "%d", *value);
    if (!ImGui::BeginCombo(label, text))
        return false;
    for (int n = least; n <= most; n *= 2) {
        snprintf(text, sizeof text, "%d", n);
        if (ImGui::Selectable(text, n == *value)) {
            *value = n;
            changed = true;
        }
    }
    ImGui::EndCombo();
    return changed;
}

// Returns whether the setting was changed.
bool show_value(const view_control *c, view_settings *s)
{
    void *field = view_control_field(c, s);
    const ibl_option *o = &c->option;
    const bool own = c->slide[0] != c->slide[1];
    const double low = own ? c->slide[0] : o->low;
    const double high = own ? c->slide[1] : o->high;
    const int first = (int)low, last = (int)high;

    switch (c->shape) {
    case VIEW_TWO_INTS:
        return ImGui::SliderInt2(c->label, (int *)field, first, last);
    case VIEW_TWO_REALS:
        return ImGui::SliderScalarN(c->label, ImGuiDataType_Double, field, 2,
                                    &low, &high, "%.3g");
    case VIEW_DOUBLED:
        return show_doubled(c->label, (int *)field, first, last);
    case VIEW_COLOUR3: {
        double *to = (double *)field;
        float rgb[3] = {(float)to[0], (float)to[1], (float)to[2]};
        const bool changed = ImGui::ColorEdit3(
            c->label, rgb, ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR);
        for (int k = 0; changed && k < 3; k++)
            to[k] = (double)rgb[k];
        return changed;
    }
    case VIEW_AS_OPTION:
        break;
    }
    switch (o->kind) {
    case IBL_OPTION_ON:
    case IBL_OPTION_OFF:
        return ImGui::Checkbox(c->label, (bool *)field);
    case IBL_OPTION_CHOICE:
        return show_choice(c->label, (int *)field, o->choices);
    case IBL_OPTION_INT:
        return ImGui::SliderInt(c->label, (int *)field, first, last);
    default:
        return ImGui::SliderScalar(c->label, ImGuiDataType_Double, field, &low,
                                   &high, "%.4g",
                                   low > 0 ? ImGuiSliderFlags_Logarithmic : 0);
    }
}

void show_section(view_app *app, const ibl_section *section)
{
    for (int i = 0; i < section->count; i++) {
        const view_control *c =
            (const view_control *)ibl_section_at(section, i);
        const int side = view_control_of_side(c) ? app->edited : 0;
        const char *why = view_app_why(app, c);
        if (!c->label)
            continue;
        ImGui::BeginDisabled(why);
        if (show_value(c, &app->side[side]))
            view_app_fit(app);
        ImGui::EndDisabled();
        say_why(why);
    }
}

// Whether a section has a control that changes something.
bool applies(const view_app *app, const ibl_section *section)
{
    for (int i = 0; i < section->count; i++) {
        const view_control *c =
            (const view_control *)ibl_section_at(section, i);
        if (c->label && !view_app_why(app, c))
            return true;
    }
    return false;
}

void show_sides(view_app *app)
{
    if (app->side[0].compare == VIEW_ALONE)
        app->edited = 0;
    else {
        ImGui::RadioButton("left", &app->edited, 0);
        ImGui::SameLine();
        ImGui::RadioButton("right", &app->edited, 1);
    }
}

void show_panel(view_app *app)
{
    const float width = (float)view_app_panel_width(app);

    ImGui::SetNextWindowPos(ImVec2((float)app->width - width, 0));
    ImGui::SetNextWindowSize(ImVec2(width, (float)app->height));
    ImGui::Begin("controls", nullptr,
                 ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                     ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoTitleBar);
    ImGui::PushItemWidth(-0.48F * width);
    if (ImGui::Button("Open") && !view_app_list(app))
        view_app_notice_failure(app);
    ImGui::SameLine();
    if (ImGui::Button("Picture"))
        app->wants_picture = true;
    ImGui::SameLine();
    if (ImGui::Button("Keys"))
        app->help = !app->help;
    ImGui::SameLine();
    if (ImGui::Button("Hide"))
        app->panel = false;
    show_sides(app);
    for (int i = 0; view_control_sections[i]; i++) {
        const ibl_section *section = view_control_sections[i];
        if (applies(app, section) &&
            ImGui::CollapsingHeader(section->title,
                                    ImGuiTreeNodeFlags_DefaultOpen))
            show_section(app, section);
    }
    ImGui::PopItemWidth();
    ImGui::End();
}

// ---- help, files, messages -------------------------------------------------

// A window in the middle. False: it was closed.
bool begin_dialog(view_app *app, const char *title, float width, bool *open)
{
    ImGui::SetNextWindowPos(
        ImVec2(0.5F * (float)app->width, 0.5F * (float)app->height),
        ImGuiCond_Always, ImVec2(0.5F, 0.5F));
    ImGui::SetNextWindowSize(ImVec2(fminf(width * ui.scale, (float)app->width),
                                    fminf(560 * ui.scale, (float)app->height)));
    return ImGui::Begin(title, open,
                        ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                            ImGuiWindowFlags_NoCollapse);
}

void show_help(view_app *app)
{
    const char *title = "";
    view_key_line line;

    if (begin_dialog(app, "Keys", 620, &app->help) &&
        ImGui::BeginTable("keys", 2)) {
        ImGui::TableSetupColumn("key", ImGuiTableColumnFlags_WidthFixed,
                                150 * ui.scale);
        ImGui::TableSetupColumn("what");
        for (int i = 0; view_key_line_at(i, &line); i++) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            if (strcmp(title, line.title) != 0) {
                title = line.title;
                ImGui::TextColored(ImVec4(0.6F, 0.8F, 1, 1), "%s", title);
                ImGui::TableNextRow();
                ImGui::TableNextColumn();
            }
            ImGui::TextUnformatted(line.keys);
            ImGui::TableNextColumn();
            ImGui::TextWrapped("%s", line.what);
        }
        ImGui::EndTable();
    }
    ImGui::End();
}

// The list of a folder, its parent first.
void show_files(view_app *app)
{
    static const char *const kinds[] = {"",      "map",    "set",
                                        "model", "probes", "folder"};
    const char *name = nullptr;

    if (begin_dialog(app, "Open", 520, &app->files)) {
        ImGui::TextWrapped("%s", app->folder.path);
        ImGui::Separator();
        ImGui::BeginChild("list");
        if (ImGui::Selectable(".."))
            name = "..";
        for (int i = 0; i < app->folder.count; i++) {
            const view_entry *e = &app->folder.entry[i];
            ImGui::PushID(i);
            if (ImGui::Selectable(e->name))
                name = e->name;
            ImGui::SameLine(400 * ui.scale);
            ImGui::TextDisabled("%s", kinds[e->kind]);
            ImGui::PopID();
        }
        ImGui::EndChild();
    }
    ImGui::End();
    if (name)
        view_app_choose(app, name);
}

void show_progress(view_app *app)
{
    ImGui::SetNextWindowPos(
        ImVec2(0.5F * (float)app->width, 0.5F * (float)app->height),
        ImGuiCond_Always, ImVec2(0.5F, 0.5F));
    ImGui::SetNextWindowSize(ImVec2(0.5F * (float)app->width, 0));
    ImGui::Begin("progress", nullptr, ImGuiWindowFlags_NoDecoration);
    ImGui::TextWrapped("baking %s: %s", app->baking, app->stage);
    ImGui::ProgressBar((float)app->baked);
    ImGui::End();
}

void show_notice(view_app *app)
{
    const double room =
        app->width - (app->panel ? view_app_panel_width(app) : 0);

    ImGui::SetNextWindowPos(
        ImVec2(0.5F * (float)room, (float)app->height - 40 * ui.scale),
        ImGuiCond_Always, ImVec2(0.5F, 1));
    ImGui::SetNextWindowSize(ImVec2(0, 0));
    ImGui::Begin("notice", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs);
    ImGui::PushTextWrapPos(0.8F * (float)room);
    if (app->failed)
        ImGui::TextColored(ImVec4(1, 0.6F, 0.5F, 1), "%s", app->notice);
    else
        ImGui::TextUnformatted(app->notice);
    ImGui::PopTextWrapPos();
    ImGui::End();
}

} // namespace

// ---- begin and end
// -----------------------------------------------------------

bool view_ui_make(double scale)
{
    ui = {};
    ui.scale = (float)scale;
    ImGui::SetAllocatorFunctions(need_bytes, free_bytes);
    ImGui::CreateContext();
    ImGui::StyleColorsDark();
    ImGui::GetStyle().ScaleAllSizes(ui.scale);
    ImGui::GetStyle().WindowRounding = 0;
    ImGui::GetIO().IniFilename = nullptr;
    ui.program = view_program("ui.vert", "ui.frag");
    if (!ui.program)
        return false;
    ui.window = gl.GetUniformLocation(ui.program, "window");
    ui.kind = gl.GetUniformLocation(ui.program, "kind");
    if (!make_font())
        return false;
    make_arrays();
    return view_gl_check("making the user interface");
}

void view_ui_free(void)
{
    if (ui.attached)
        ImGui_ImplGlfw_Shutdown();
    if (ImGui::GetCurrentContext())
        ImGui::DestroyContext();
    ui.attached = false;
}

void view_ui_attach(GLFWwindow *window)
{
    ui.attached = ImGui_ImplGlfw_InitForOther(window, true);
}

void view_ui_pointer(double x, double y, bool down)
{
    ImGui::GetIO().MousePos = ImVec2((float)x, (float)y);
    ImGui::GetIO().MouseDown[0] = down;
}

bool view_ui_has_pointer(void)
{
    return ImGui::GetIO().WantCaptureMouse;
}

bool view_ui_has_keys(void)
{
    return ImGui::GetIO().WantTextInput;
}

void view_ui_begin(int width, int height)
{
    ImGuiIO &io = ImGui::GetIO();

    ui.width = width, ui.height = height;
    if (ui.attached) {
        ImGui_ImplGlfw_NewFrame();
        // The pointer is in units of the screen.
        if (io.MousePos.x > -FLT_MAX && io.DisplaySize.x > 0) {
            io.MousePos.x *= (float)width / io.DisplaySize.x;
            io.MousePos.y *= (float)height / io.DisplaySize.y;
        }
    }
    io.DisplaySize = ImVec2((float)width, (float)height);
    io.DisplayFramebufferScale = ImVec2(1, 1);
    ImGui::NewFrame();
}

void view_ui_end(unsigned framebuffer)
{
    ImGui::Render();
    const ImDrawData *data = ImGui::GetDrawData();

    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl.Viewport(0, 0, ui.width, ui.height);
    gl.UseProgram(ui.program);
    gl.Uniform2f(ui.window, (float)ui.width, (float)ui.height);
    view_gl_bind(VIEW_UNIT_PICTURE, GL_TEXTURE_2D, ui.font);
    gl.BindVertexArray(ui.array);
    gl.BindBuffer(GL_ARRAY_BUFFER, ui.vertices);
    gl.Enable(GL_BLEND);
    gl.Enable(GL_SCISSOR_TEST);
    for (int i = 0; i < data->CmdListsCount; i++)
        draw_list(data->CmdLists[i]);
    gl.Disable(GL_SCISSOR_TEST);
    gl.Disable(GL_BLEND);
}

// ---- on pictures
// -------------------------------------------------------------

void view_ui_measure(const char *text, double *width, double *height)
{
    const ImVec2 size = ImGui::CalcTextSize(text);

    *width = (double)size.x;
    *height = (double)size.y;
}

void view_ui_text(double x, double y, const double point[2], const char *text)
{
    const ImVec2 size = ImGui::CalcTextSize(text);

    // Whole pixels keep letters sharp.
    page()->AddText(
        ImVec2(floorf((float)(x - point[0] * (double)size.x) + 0.5F),
               floorf((float)(y - point[1] * (double)size.y) + 0.5F)),
        colour_of(0xe8e8e8), text);
}

void view_ui_legend(double x, double y, double width, double most)
{
    const double height = 10 * (double)ui.scale;

    page()->AddImage((ImTextureID)(intptr_t)(most > 0 ? greys : false_colours),
                     ImVec2((float)x, (float)y),
                     ImVec2((float)(x + width), (float)(y + height)));
    for (int i = 0; i <= 4; i++) {
        const int stop = 4 * i - VIEW_STOPS;
        const double point[2] = {0.25 * i, 0};
        char text[16];
        if (most > 0)
            snprintf(text, sizeof text, "%.3g", most * i / 4);
        else
            snprintf(text, sizeof text, stop ? "%+d" : "%d EV", stop);
        view_ui_text(x + 0.25 * i * width, y + height, point, text);
    }
}

// ---- the window
// ----------------------------------------------------------------

void view_ui_app(view_app *app)
{
    if (app->panel)
        show_panel(app);
    if (app->help)
        show_help(app);
    if (app->files)
        show_files(app);
    if (app->baker)
        show_progress(app);
    if (app->notice[0])
        show_notice(app);
}
