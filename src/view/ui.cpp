// SPDX-License-Identifier: MIT
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <backends/imgui_impl_glfw.h>
#include <imgui.h>
#include <imgui_internal.h>

extern "C" {
#include "common/signals.h"
#include "view/app.h"
#include "view/gl.h"
#include "view/ui.h"
}

namespace
{

const char font_file[] = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
const float text_units = 14;
const ImVec2 middle(0.5F, 0.5F);
// Textures of draw lists besides the font's: ui.frag draws them.
enum {
    letters,
    false_colours,
    greys
};

struct {
    GLuint program, array, vertices, indices, font;
    GLint window, kind;
    float scale, width, height;
    bool attached;
} ui;

ImDrawList *page()
{
    return ImGui::GetBackgroundDrawList();
}

// ---- OpenGL ----------------------------------------------------------------

// ImGui ends the program where it fails to read a file.
void make_font()
{
    ImFontAtlas *fonts = ImGui::GetIO().Fonts;
    const int file = open(font_file, O_RDONLY);
    struct stat st = {};
    ImFontConfig own;
    unsigned char *pixels = nullptr;
    int width = 0, height = 0;

    fstat(file, &st);
    void *font =
        mmap(nullptr, (size_t)st.st_size, PROT_READ, MAP_PRIVATE, file, 0);
    close(file);
    own.FontDataOwnedByAtlas = false;
    own.SizePixels = floorf(text_units * ui.scale + 0.5F);
    if (font == MAP_FAILED)
        fonts->AddFontDefault(&own);
    else
        fonts->AddFontFromMemoryTTF(font, (int)st.st_size, own.SizePixels,
                                    &own);
    fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
    gl.GenTextures(1, &ui.font);
    view_gl_bind(VIEW_UNIT_PICTURE, GL_TEXTURE_2D, ui.font);
    view_gl_filter(GL_TEXTURE_2D, GL_LINEAR, 1);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA,
                  GL_UNSIGNED_BYTE, pixels);
    fonts->SetTexID((ImTextureID)(intptr_t)letters);
}

void make_arrays()
{
    const size_t vertex = sizeof(ImDrawVert);

    gl.GenVertexArrays(1, &ui.array);
    gl.BindVertexArray(ui.array);
    ui.vertices = view_gl_buffer(GL_ARRAY_BUFFER, 0, nullptr);
    ui.indices = view_gl_buffer(GL_ELEMENT_ARRAY_BUFFER, 0, nullptr);
    view_gl_attribute(0, 2, vertex, offsetof(ImDrawVert, pos));
    view_gl_attribute(1, 2, vertex, offsetof(ImDrawVert, uv));
    gl.EnableVertexAttribArray(2);
    gl.VertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, vertex,
                           (const void *)offsetof(ImDrawVert, col));
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
        gl.Scissor((GLint)clip.x, (GLint)(ui.height - clip.w),
                   (GLsizei)fmaxf(clip.z - clip.x, 0),
                   (GLsizei)fmaxf(clip.w - clip.y, 0));
        gl.Uniform1i(ui.kind, (GLint)(intptr_t)c.TextureId);
        gl.DrawElements(GL_TRIANGLES, (GLsizei)c.ElemCount, GL_UNSIGNED_SHORT,
                        (const void *)(offset * sizeof(ImDrawIdx)));
        offset += c.ElemCount;
    }
}

// ---- windows ---------------------------------------------------------------

// Begins a window with a point of it, in fractions of its size, at `at`. Sizes
// of 0 are those of what is in it. False: it is folded.
bool begin_window(const char *title, ImVec2 at, ImVec2 point, ImVec2 size,
                  ImGuiWindowFlags flags, bool *open = nullptr)
{
    ImGui::SetNextWindowPos(at, ImGuiCond_Always, point);
    ImGui::SetNextWindowSize(size);
    return ImGui::Begin(title, open,
                        flags | ImGuiWindowFlags_NoMove |
                            ImGuiWindowFlags_NoResize |
                            ImGuiWindowFlags_NoCollapse);
}

bool begin_dialog(const char *title, float width, bool *open)
{
    return begin_window(title, ImVec2(0.5F * ui.width, 0.5F * ui.height),
                        middle,
                        ImVec2(fminf(width * ui.scale, ui.width),
                               fminf(560 * ui.scale, ui.height)),
                        0, open);
}

// ---- the panel -------------------------------------------------------------

bool show_colour(const char *label, double *rgb)
{
    float shown[3] = {(float)rgb[0], (float)rgb[1], (float)rgb[2]};

    if (!ImGui::ColorEdit3(label, shown,
                           ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR))
        return false;
    for (int k = 0; k < 3; k++)
        rgb[k] = (double)shown[k];
    return true;
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
    const int count =
        c->shape == VIEW_TWO_INTS || c->shape == VIEW_TWO_REALS ? 2 : 1;

    if (c->shape == VIEW_COLOUR3)
        return show_colour(c->label, (double *)field);
    if (o->kind == IBL_OPTION_ON || o->kind == IBL_OPTION_OFF)
        return ImGui::Checkbox(c->label, (bool *)field);
    if (o->kind == IBL_OPTION_CHOICE)
        return ImGui::Combo(c->label, (int *)field, o->choices,
                            view_control_choices(c));
    if (o->kind == IBL_OPTION_INT || c->shape == VIEW_TWO_INTS)
        return ImGui::SliderScalarN(c->label, ImGuiDataType_S32, field, count,
                                    &first, &last);
    return ImGui::SliderScalarN(c->label, ImGuiDataType_Double, field, count,
                                &low, &high, "%.4g",
                                low > 0 ? ImGuiSliderFlags_Logarithmic : 0);
}

// Shows the controls of a section, if one of them changes something.
void show_section(view_app *app, const ibl_section *section)
{
    const auto control = [=](int i) {
        return (const view_control *)ibl_section_at(section, i);
    };
    int first = 0;

    while (first < section->count &&
           (!control(first)->label || view_app_why(app, control(first))))
        first++;
    if (first == section->count ||
        !ImGui::CollapsingHeader(section->title,
                                 ImGuiTreeNodeFlags_DefaultOpen))
        return;
    for (int i = 0; i < section->count; i++) {
        const view_control *c = control(i);
        const char *why = view_app_why(app, c);
        if (!c->label)
            continue;
        ImGui::BeginDisabled(why);
        if (show_value(c,
                       &app->side[view_control_of_side(c) ? app->edited : 0]))
            view_app_fit(app);
        ImGui::EndDisabled();
        if (why && ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
            ImGui::SetTooltip("%s", why);
    }
}

void show_panel(view_app *app)
{
    const float width = (float)view_app_panel_width(app);

    begin_window("controls", ImVec2(ui.width, 0), ImVec2(1, 0),
                 ImVec2(width, ui.height), ImGuiWindowFlags_NoTitleBar);
    ImGui::PushItemWidth(-0.48F * width);
    if (ImGui::Button("Open"))
        view_app_list(app);
    ImGui::SameLine();
    if (ImGui::Button("Picture"))
        app->wants_picture = true;
    ImGui::SameLine();
    if (ImGui::Button("Keys"))
        app->help = !app->help;
    ImGui::SameLine();
    if (ImGui::Button("Hide"))
        app->panel = false;
    if (app->side[0].compare) {
        ImGui::RadioButton("left", &app->edited, 0);
        ImGui::SameLine();
        ImGui::RadioButton("right", &app->edited, 1);
    }
    for (int i = 0; view_control_sections[i]; i++)
        show_section(app, view_control_sections[i]);
    ImGui::PopItemWidth();
    ImGui::End();
}

// ---- help, files, messages -------------------------------------------------

void show_help(view_app *app)
{
    const char *title = "";
    view_key_line line;

    if (begin_dialog("Keys", 620, &app->help) && ImGui::BeginTable("keys", 2)) {
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

    if (begin_dialog("Open", 520, &app->files)) {
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
            ImGui::SameLine(0.8F * ImGui::GetWindowWidth());
            ImGui::TextDisabled("%s", kinds[e->kind]);
            ImGui::PopID();
        }
        ImGui::EndChild();
    }
    ImGui::End();
    if (name)
        view_app_choose(app, name);
}

void show_progress(const view_app *app)
{
    begin_window("progress", ImVec2(0.5F * ui.width, 0.5F * ui.height), middle,
                 ImVec2(0.5F * ui.width, 0), ImGuiWindowFlags_NoDecoration);
    ImGui::TextWrapped("baking %s", app->baking);
    ImGui::ProgressBar((float)app->baked);
    ImGui::End();
}

void show_notice(const view_app *app)
{
    const int panel = app->panel ? view_app_panel_width(app) : 0;
    const float room = ui.width - (float)panel;

    // A window that fits itself to its text does so a frame late.
    const ImVec2 pad = ImGui::GetStyle().WindowPadding;
    const ImVec2 text =
        ImGui::CalcTextSize(app->notice, nullptr, false, 0.8F * room);

    begin_window("notice", ImVec2(0.5F * room, ui.height - 40 * ui.scale),
                 ImVec2(0.5F, 1),
                 ImVec2(text.x + 2 * pad.x + 1, text.y + 2 * pad.y),
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs);
    ImGui::BringWindowToDisplayFront(ImGui::GetCurrentWindow());
    ImGui::PushTextWrapPos(pad.x + 0.8F * room);
    ImGui::TextColored(app->failed ? ImVec4(1, 0.6F, 0.5F, 1)
                                   : ImVec4(1, 1, 1, 1),
                       "%s", app->notice);
    ImGui::PopTextWrapPos();
    ImGui::End();
}

} // namespace

// ---- begin and end ---------------------------------------------------------

bool view_ui_make(double scale)
{
    ui = {};
    ui.scale = (float)scale;
    // ImGui does not look at what it is given.
    ImGui::SetAllocatorFunctions(
        [](size_t size, void *) { return ibl_need(malloc(size)); },
        [](void *p, void *) { free(p); });
    ImGui::CreateContext();
    ImGui::StyleColorsDark();
    ImGui::GetStyle().ScaleAllSizes(ui.scale);
    ImGui::GetStyle().WindowRounding = 0;
    ImGui::GetIO().IniFilename = nullptr;
    ui.program = view_program("", "ui.vert", "ui.frag");
    if (!ui.program)
        return false;
    ui.window = gl.GetUniformLocation(ui.program, "window");
    ui.kind = gl.GetUniformLocation(ui.program, "kind");
    make_font();
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

    ui.width = (float)width, ui.height = (float)height;
    if (ui.attached) {
        ImGui_ImplGlfw_NewFrame();
        // The pointer is in units of the screen.
        if (io.MousePos.x > -FLT_MAX && io.DisplaySize.x > 0) {
            io.MousePos.x *= ui.width / io.DisplaySize.x;
            io.MousePos.y *= ui.height / io.DisplaySize.y;
        }
    }
    io.DisplaySize = ImVec2(ui.width, ui.height);
    io.DisplayFramebufferScale = ImVec2(1, 1);
    ImGui::NewFrame();
}

void view_ui_end(unsigned framebuffer)
{
    ImGui::Render();
    const ImDrawData *data = ImGui::GetDrawData();

    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl.Viewport(0, 0, (GLsizei)ui.width, (GLsizei)ui.height);
    gl.UseProgram(ui.program);
    gl.Uniform2f(ui.window, ui.width, ui.height);
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

// ---- on pictures -----------------------------------------------------------

void view_ui_text(double x, double y, const double point[2], const char *text)
{
    const ImVec2 size = ImGui::CalcTextSize(text);

    // Whole pixels keep letters sharp.
    page()->AddText(
        ImVec2(floorf((float)(x - point[0] * (double)size.x) + 0.5F),
               floorf((float)(y - point[1] * (double)size.y) + 0.5F)),
        IM_COL32(232, 232, 232, 255), text);
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
    // A release that came with the press is seen by the next frame.
    app->redraw |= ImGui::IsAnyMouseDown();
}
