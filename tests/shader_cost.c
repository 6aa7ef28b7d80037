/* SPDX-License-Identifier: MIT */
/*
 * What a fragment shader costs by the estimate of a compiler for an integrated
 * GPU: shader_cost NAME VERT.spv FRAG.spv [NAME VERT.spv FRAG.spv]...
 *
 * Mesa's RADV makes a device without hardware if RADV_FORCE_FAMILY names one;
 * pipelines are compiled for it, and VK_KHR_pipeline_executable_properties
 * tells what the compiler (ACO) thinks of them. Nothing is drawn. SPIR-V tells
 * how many lookups there are; how often a loop turns is assumed.
 *
 * Ends with 77 if there is no such device.
 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <vulkan/vulkan.h>

/* The name is too long for a line. */
#define FEATURES(x) VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_##x##_FEATURES_KHR

/* Vega 8: Ryzen 3 2200G and the like. A unit filters four texels of 32 bits a
 * clock: of 64 bits half as many, half of that between two levels, as many as
 * are fetched of 128 bits. */
static const double units = 8, simds = 8 * 4, clock_hz = 1.1e9;
static const double pixels = 1920 * 1080, budget_ms = 1000.0 / 60;

enum {
    WAVE = 64,
    ISSUE = 4, /* cycles of a SIMD of 16 lanes for an instruction of a wave */
    MAX_ROWS = 16,
    NO_DEVICE = 77,
    BINDINGS = 32,
    STATISTICS = 64,
    EXECUTABLES = 8,
    CALLS = 64,
    LOOPS = 8, /* one in the other */
    TURNS = 3  /* of each loop: those over 3 x 3 texels are exact */
};

static void fail(const char *what, const char *name)
{
    fprintf(stderr, "shader_cost: %s: %s\n", name, what);
    exit(1);
}

static void must(VkResult result, const char *what)
{
    if (result < 0) {
        fprintf(stderr, "shader_cost: %s: VkResult %d\n", what, result);
        exit(1);
    }
}

/* ---- SPIR-V ------------------------------------------------------------ */

/* From the specification of SPIR-V 1.3. */
enum {
    OP_TYPE_IMAGE = 25,
    OP_TYPE_SAMPLED_IMAGE = 27,
    OP_TYPE_ARRAY = 28,
    OP_TYPE_STRUCT = 30,
    OP_TYPE_POINTER = 32,
    OP_CONSTANT = 43,
    OP_FUNCTION = 54,
    OP_FUNCTION_CALL = 57,
    OP_VARIABLE = 59,
    OP_LOAD = 61,
    OP_DECORATE = 71,
    OP_SAMPLED_IMAGE = 86,
    OP_SAMPLE_FIRST = 87, /* and all that look up a texture, */
    OP_FETCH_LAST = 98,   /* up to OpImageRead */
    OP_IMAGE = 100,
    OP_ENTRY_POINT = 15,
    DECORATION_LOCATION = 30,
    DECORATION_BINDING = 33,
    STORAGE_INPUT = 1,
    OP_ACCESS_CHAIN = 65,
    OP_LOOP_MERGE = 246,
    OP_LABEL = 248,
    DIM_CUBE = 3,
    DIM_BUFFER = 5
};

typedef struct lookups {
    int cube, flat, buffer;
} lookups;

typedef struct module {
    const char *name;
    uint32_t *words;
    size_t count;
    uint32_t bound;
    const uint32_t **made; /* the instruction that makes an id, or NULL */
    uint32_t *type;        /* of an id's value, or 0 */
    int *location, *binding;
    lookups *direct; /* of a function */
    struct {
        uint32_t from, to;
        int times;
    } call[CALLS];
    int calls;
    bool *used;
    uint32_t loop_end[LOOPS]; /* labels, of where the reading is */
    int loops;
    uint32_t entry;
} module;

static uint32_t *read_words(const char *path, size_t *count)
{
    FILE *f = fopen(path, "rb");
    uint32_t *words = NULL;

    if (f && !fseek(f, 0, SEEK_END)) {
        const long bytes = ftell(f);
        *count = bytes > 0 ? (size_t)bytes / 4 : 0;
        words = malloc(*count * 4 + 4);
        rewind(f);
        if (words && fread(words, 4, *count, f) != *count)
            *count = 0;
    }
    if (f)
        fclose(f);
    if (!words || *count < 5 || words[0] != 0x07230203)
        fail("is no SPIR-V", path);
    return words;
}

static const uint32_t *made(const module *m, uint32_t id)
{
    if (!m->made[id])
        fail("has an id that nothing makes", m->name);
    return m->made[id];
}

static uint32_t op(const uint32_t *word)
{
    return word[0] & 0xffff;
}

/* The type that a pointer to an array or not leads to. */
static const uint32_t *pointed(const module *m, uint32_t pointer, int *length)
{
    const uint32_t *t = made(m, made(m, pointer)[3]);

    *length = 1;
    if (op(t) == OP_TYPE_ARRAY) {
        *length = (int)made(m, t[3])[3];
        t = made(m, t[2]);
    }
    return t;
}

/* How often what is being read is done. */
static int times(const module *m)
{
    int n = 1;

    for (int i = 0; i < m->loops; i++)
        n *= TURNS;
    return n;
}

static void add_lookup(module *m, uint32_t function, uint32_t image)
{
    const uint32_t *t = made(m, m->type[image]);

    if (op(t) == OP_TYPE_SAMPLED_IMAGE)
        t = made(m, t[2]);
    if (op(t) != OP_TYPE_IMAGE)
        fail("looks something up that is no image", m->name);
    if (t[3] == DIM_CUBE)
        m->direct[function].cube += times(m);
    else if (t[3] == DIM_BUFFER)
        m->direct[function].buffer += times(m);
    else
        m->direct[function].flat += times(m);
}

/* What all instructions in the viewer's shaders need, and no more. */
static void take(module *m, const uint32_t *w, uint32_t *function)
{
    const uint32_t code = op(w);

    if ((code >= OP_TYPE_IMAGE && code <= OP_TYPE_STRUCT) ||
        code == OP_TYPE_POINTER)
        m->made[w[1]] = w;
    if (code == OP_CONSTANT || code == OP_VARIABLE || code == OP_FUNCTION)
        m->made[w[2]] = w;
    if (code == OP_LOAD || code == OP_IMAGE || code == OP_SAMPLED_IMAGE)
        m->type[w[2]] = w[1];
    if (code == OP_ENTRY_POINT)
        m->entry = w[2];
    if (code == OP_DECORATE && w[2] == DECORATION_LOCATION)
        m->location[w[1]] = (int)w[3];
    if (code == OP_DECORATE && w[2] == DECORATION_BINDING)
        m->binding[w[1]] = (int)w[3];
    if (code == OP_FUNCTION)
        *function = w[2];
    if (code >= OP_SAMPLE_FIRST && code <= OP_FETCH_LAST)
        add_lookup(m, *function, w[3]);
    if (code == OP_FUNCTION_CALL) {
        if (m->calls == CALLS)
            fail("calls too many functions", m->name);
        m->call[m->calls].from = *function;
        m->call[m->calls].times = times(m);
        m->call[m->calls++].to = w[3];
        for (uint32_t i = 4; i < w[0] >> 16; i++)
            m->used[w[i]] = true;
    }
    if (code == OP_LOAD || code == OP_ACCESS_CHAIN)
        m->used[w[3]] = true;
    if (code == OP_LOOP_MERGE) {
        if (m->loops == LOOPS)
            fail("has too many loops in each other", m->name);
        m->loop_end[m->loops++] = w[1];
    }
    if (code == OP_LABEL && m->loops && m->loop_end[m->loops - 1] == w[1])
        m->loops--;
}

static void *zeroed(size_t count, size_t size)
{
    void *p = calloc(count, size);

    if (!p)
        fail("no memory", "SPIR-V");
    return p;
}

static module load(const char *path)
{
    module m = {.name = path};
    uint32_t function = 0;

    m.words = read_words(path, &m.count);
    m.bound = m.words[3];
    m.made = zeroed(m.bound, sizeof *m.made);
    m.type = zeroed(m.bound, sizeof *m.type);
    m.location = zeroed(m.bound, sizeof *m.location);
    m.binding = zeroed(m.bound, sizeof *m.binding);
    m.used = zeroed(m.bound, sizeof *m.used);
    m.direct = zeroed(m.bound, sizeof *m.direct);
    for (uint32_t i = 0; i < m.bound; i++)
        m.location[i] = m.binding[i] = -1;
    for (size_t at = 5; at < m.count;) {
        const size_t length = m.words[at] >> 16;
        if (!length || at + length > m.count)
            fail("is cut short", path);
        take(&m, m.words + at, &function);
        at += length;
    }
    return m;
}

static void unload(module *m)
{
    free(m->direct);
    free(m->used);
    free(m->binding);
    free(m->location);
    free(m->type);
    free(m->made);
    free(m->words);
}

/* Of a function and all that it calls; SPIR-V has no recursion. */
static lookups count_lookups(const module *m, uint32_t function)
{
    lookups sum = m->direct[function];

    for (int i = 0; i < m->calls; i++)
        if (m->call[i].from == function) {
            const lookups l = count_lookups(m, m->call[i].to);
            sum.cube += m->call[i].times * l.cube;
            sum.flat += m->call[i].times * l.flat;
            sum.buffer += m->call[i].times * l.buffer;
        }
    return sum;
}

/* ---- the pipeline ------------------------------------------------------ */

typedef struct gpu {
    VkInstance instance;
    VkDevice device;
    VkPhysicalDeviceProperties about;
} gpu;

static VkPhysicalDevice find_device(VkInstance instance)
{
    VkPhysicalDevice all[16];
    uint32_t count = 16;
    VkPhysicalDeviceProperties p;

    if (vkEnumeratePhysicalDevices(instance, &count, all) < 0)
        exit(NO_DEVICE);
    for (uint32_t i = 0; i < count; i++) {
        vkGetPhysicalDeviceProperties(all[i], &p);
        if (strstr(p.deviceName, "RADV"))
            return all[i];
    }
    exit(NO_DEVICE);
}

static gpu open_gpu(void)
{
    static const char *const extensions[] = {
        "VK_KHR_pipeline_executable_properties"};
    static const float priority = 1;
    const VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                   .apiVersion = VK_API_VERSION_1_1};
    const VkInstanceCreateInfo with = {
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pApplicationInfo = &app};
    VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR features = {
        .sType = FEATURES(PIPELINE_EXECUTABLE_PROPERTIES),
        .pipelineExecutableInfo = VK_TRUE};
    const VkPhysicalDeviceFeatures clip = {.shaderClipDistance = VK_TRUE,
                                           .imageCubeArray = VK_TRUE};
    const VkDeviceQueueCreateInfo queue = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
        .queueCount = 1,
        .pQueuePriorities = &priority};
    const VkDeviceCreateInfo device = {.sType =
                                           VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                       .pNext = &features,
                                       .queueCreateInfoCount = 1,
                                       .pQueueCreateInfos = &queue,
                                       .enabledExtensionCount = 1,
                                       .ppEnabledExtensionNames = extensions,
                                       .pEnabledFeatures = &clip};
    gpu g = {0};

    if (vkCreateInstance(&with, NULL, &g.instance) < 0)
        exit(NO_DEVICE); /* no driver at all */
    const VkPhysicalDevice physical = find_device(g.instance);
    vkGetPhysicalDeviceProperties(physical, &g.about);
    must(vkCreateDevice(physical, &device, NULL, &g.device), "a device");
    return g;
}

static VkDescriptorType descriptor(const module *m, const uint32_t *type)
{
    if (op(type) == OP_TYPE_STRUCT)
        return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    return op(type) == OP_TYPE_IMAGE || made(m, type[2])[3] == DIM_BUFFER
               ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER
               : VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
}

/* Adds the resources of a module to a set's bindings. */
static void add_bindings(const module *m, VkShaderStageFlags stage,
                         VkDescriptorSetLayoutBinding *set)
{
    for (uint32_t id = 0; id < m->bound; id++) {
        const int b = m->binding[id];
        int length;
        /* What is not used may share its place with something else. */
        if (b < 0 || !m->used[id])
            continue;
        if (b >= BINDINGS)
            fail("has too many bindings", m->name);
        const uint32_t *t = pointed(m, made(m, id)[1], &length);
        const VkDescriptorType type = descriptor(m, t);
        if (set[b].descriptorCount && set[b].descriptorType != type)
            fail("has another binding than its other half", m->name);
        set[b].binding = (uint32_t)b;
        set[b].descriptorType = type;
        set[b].descriptorCount = (uint32_t)length;
        set[b].stageFlags |= stage;
    }
}

static VkPipelineLayout make_layout(VkDevice device, const module *vertex,
                                    const module *fragment)
{
    VkDescriptorSetLayoutBinding all[BINDINGS] = {0}, used[BINDINGS];
    VkDescriptorSetLayoutCreateInfo set = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
        .pBindings = used};
    VkDescriptorSetLayout made_set;
    VkPipelineLayout layout;

    add_bindings(vertex, VK_SHADER_STAGE_VERTEX_BIT, all);
    add_bindings(fragment, VK_SHADER_STAGE_FRAGMENT_BIT, all);
    for (int i = 0; i < BINDINGS; i++)
        if (all[i].descriptorCount)
            used[set.bindingCount++] = all[i];
    must(vkCreateDescriptorSetLayout(device, &set, NULL, &made_set), "a set");
    const VkPipelineLayoutCreateInfo o = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
        .setLayoutCount = 1,
        .pSetLayouts = &made_set};
    must(vkCreatePipelineLayout(device, &o, NULL, &layout), "a layout");
    return layout;
}

/* One picture of floats, as the viewer's linear one, and no depth. */
static VkRenderPass make_pass(VkDevice device)
{
    const VkAttachmentDescription picture = {
        .format = VK_FORMAT_R32G32B32A32_SFLOAT,
        .samples = VK_SAMPLE_COUNT_1_BIT,
        .finalLayout = VK_IMAGE_LAYOUT_GENERAL};
    const VkAttachmentReference to = {0, VK_IMAGE_LAYOUT_GENERAL};
    const VkSubpassDescription subpass = {.colorAttachmentCount = 1,
                                          .pColorAttachments = &to};
    const VkRenderPassCreateInfo o = {
        .sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
        .attachmentCount = 1,
        .pAttachments = &picture,
        .subpassCount = 1,
        .pSubpasses = &subpass};
    VkRenderPass pass;

    must(vkCreateRenderPass(device, &o, NULL, &pass), "a render pass");
    return pass;
}

static VkPipelineShaderStageCreateInfo
make_stage(VkDevice device, const module *m, VkShaderStageFlagBits stage)
{
    const VkShaderModuleCreateInfo code = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
        .codeSize = m->count * 4,
        .pCode = m->words};
    VkPipelineShaderStageCreateInfo s = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
        .stage = stage,
        .pName = "main"};

    must(vkCreateShaderModule(device, &code, NULL, &s.module), m->name);
    return s;
}

static uint32_t find_attributes(const module *vertex,
                                VkVertexInputAttributeDescription *attributes)
{
    uint32_t count = 0;

    for (uint32_t id = 0; id < vertex->bound; id++) {
        const uint32_t *w = vertex->made[id];
        if (w && op(w) == OP_VARIABLE && w[3] == STORAGE_INPUT &&
            vertex->location[id] >= 0 && count < BINDINGS)
            attributes[count++] = (VkVertexInputAttributeDescription){
                .location = (uint32_t)vertex->location[id],
                .format = VK_FORMAT_R32G32B32A32_SFLOAT};
    }
    return count;
}

static VkPipeline make_pipeline(VkDevice device, const module *vertex,
                                const module *fragment)
{
    VkVertexInputAttributeDescription attributes[BINDINGS];
    const VkVertexInputBindingDescription stride = {.stride = 256};
    const uint32_t count = find_attributes(vertex, attributes);
    const VkPipelineShaderStageCreateInfo stages[] = {
        make_stage(device, vertex, VK_SHADER_STAGE_VERTEX_BIT),
        make_stage(device, fragment, VK_SHADER_STAGE_FRAGMENT_BIT)};
    const VkPipelineVertexInputStateCreateInfo input = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
        .vertexBindingDescriptionCount = count > 0,
        .pVertexBindingDescriptions = &stride,
        .vertexAttributeDescriptionCount = count,
        .pVertexAttributeDescriptions = attributes};
    const VkPipelineInputAssemblyStateCreateInfo assembly = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
    const VkViewport whole = {0, 0, 1920, 1080, 0, 1};
    const VkRect2D all = {{0, 0}, {1920, 1080}};
    const VkPipelineViewportStateCreateInfo viewport = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
        .viewportCount = 1,
        .pViewports = &whole,
        .scissorCount = 1,
        .pScissors = &all};
    const VkPipelineRasterizationStateCreateInfo raster = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
        .lineWidth = 1};
    const VkPipelineMultisampleStateCreateInfo samples = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
    const VkPipelineColorBlendAttachmentState write = {.colorWriteMask = 15};
    const VkPipelineColorBlendStateCreateInfo blend = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
        .attachmentCount = 1,
        .pAttachments = &write};
    const VkGraphicsPipelineCreateInfo o = {
        .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
        .flags = VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR,
        .stageCount = 2,
        .pStages = stages,
        .pVertexInputState = &input,
        .pInputAssemblyState = &assembly,
        .pViewportState = &viewport,
        .pRasterizationState = &raster,
        .pMultisampleState = &samples,
        .pColorBlendState = &blend,
        .layout = make_layout(device, vertex, fragment),
        .renderPass = make_pass(device)};
    VkPipeline pipeline;

    must(vkCreateGraphicsPipelines(device, VK_NULL_HANDLE, 1, &o, NULL,
                                   &pipeline),
         fragment->name);
    return pipeline;
}

/* ---- what the compiler says -------------------------------------------- */

typedef struct statistics {
    VkPipelineExecutableStatisticKHR all[STATISTICS];
    uint32_t count;
} statistics;

static PFN_vkVoidFunction find(VkDevice device, const char *name)
{
    const PFN_vkVoidFunction f = vkGetDeviceProcAddr(device, name);

    if (!f)
        fail("is not there", name);
    return f;
}

static uint32_t find_fragment(VkDevice device, VkPipeline pipeline)
{
    const PFN_vkGetPipelineExecutablePropertiesKHR get =
        (PFN_vkGetPipelineExecutablePropertiesKHR)find(
            device, "vkGetPipelineExecutablePropertiesKHR");
    const VkPipelineInfoKHR of = {.sType = VK_STRUCTURE_TYPE_PIPELINE_INFO_KHR,
                                  .pipeline = pipeline};
    VkPipelineExecutablePropertiesKHR all[EXECUTABLES] = {0};
    uint32_t count = EXECUTABLES;

    for (int i = 0; i < EXECUTABLES; i++)
        all[i].sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_PROPERTIES_KHR;
    must(get(device, &of, &count, all), "executables");
    for (uint32_t i = 0; i < count; i++)
        if (all[i].stages & VK_SHADER_STAGE_FRAGMENT_BIT)
            return i;
    fail("has no fragment shader", "pipeline");
    return 0;
}

static void get_statistics(VkDevice device, VkPipeline pipeline, statistics *s)
{
    const PFN_vkGetPipelineExecutableStatisticsKHR get =
        (PFN_vkGetPipelineExecutableStatisticsKHR)find(
            device, "vkGetPipelineExecutableStatisticsKHR");
    const VkPipelineExecutableInfoKHR of = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR,
        .pipeline = pipeline,
        .executableIndex = find_fragment(device, pipeline)};

    memset(s, 0, sizeof *s);
    s->count = STATISTICS;
    for (int i = 0; i < STATISTICS; i++)
        s->all[i].sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR;
    must(get(device, &of, &s->count, s->all), "statistics");
}

static double statistic(const statistics *s, const char *name)
{
    for (uint32_t i = 0; i < s->count; i++)
        if (!strcmp(s->all[i].name, name))
            return s->all[i].format ==
                           VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_FLOAT64_KHR
                       ? s->all[i].value.f64
                       : (double)s->all[i].value.u64;
    fail("is none of what this Mesa tells", name);
    return 0;
}

typedef struct row {
    const char *name;
    double instructions, registers, waves, latency, busy;
    lookups lookups;
    /* of all pixels; bytes of each */
    double compute_ms, issue_ms, lookup_ms, bytes;
} row;

static row make_row(const char *name, const statistics *s, lookups l)
{
    row r = {.name = name,
             .instructions = statistic(s, "Instructions"),
             .registers = statistic(s, "VGPRs"),
             .waves = statistic(s, "Subgroups per SIMD"),
             .latency = statistic(s, "Latency"),
             .busy = statistic(s, "Inverse Throughput"),
             .lookups = l};

    r.compute_ms = 1e3 * r.busy * pixels / WAVE / simds / clock_hz;
    r.issue_ms = r.compute_ms / r.busy * ISSUE * r.instructions;
    /* What is not filtered comes at four a clock. */
    r.lookup_ms =
        1e3 * (l.cube + l.flat + l.buffer / 4.0) * pixels / units / clock_hz;
    /* Eight texels of four halves between two levels of a cube; of a picture
     * one of four floats, or four of two halves; of a buffer four floats. */
    r.bytes = 64.0 * l.cube + 16.0 * (l.flat + l.buffer);
    return r;
}

static void print_row(const row *r)
{
    printf("%-13s %6.0f %5.0f %5.0f %7.0f %6.0f %6.2f %6.2f %5.1f %4d %2d "
           "%3d %6.2f %5.0f %5.1f\n",
           r->name, r->instructions, r->registers, r->waves, r->latency,
           r->busy, r->compute_ms, r->issue_ms, 100 * r->compute_ms / budget_ms,
           r->lookups.cube, r->lookups.flat, r->lookups.buffer, r->lookup_ms,
           r->bytes, r->bytes * pixels * 60 / 1e9);
}

/* Shaders that follow each other over all pixels of a frame. */
static void print_frame(const char *title, const char *const *parts,
                        const row *rows, int count)
{
    double compute = 0, issue = 0, lookup = 0, bytes = 0;

    for (; *parts; parts++)
        for (int i = 0; i < count; i++)
            if (!strcmp(rows[i].name, *parts)) {
                compute += rows[i].compute_ms;
                issue += rows[i].issue_ms;
                lookup += rows[i].lookup_ms;
                bytes += rows[i].bytes;
            }
    printf(
        "%s: %.1f ms of computing (once: %.1f), %.1f of lookups, %.0f GB/s\n",
        title, compute, issue, lookup, bytes * pixels * 60 / 1e9);
}

static row measure(const gpu *g, char **argument)
{
    module vertex = load(argument[1]), fragment = load(argument[2]);
    statistics s;

    get_statistics(g->device, make_pipeline(g->device, &vertex, &fragment), &s);
    const row r =
        make_row(argument[0], &s, count_lookups(&fragment, fragment.entry));
    unload(&vertex);
    unload(&fragment);
    return r;
}

int main(int argc, char **argv)
{
    static const char *const spheres[] = {"sky.frag", "sphere.frag",
                                          "display.frag", NULL};
    static const char *const scene[] = {"room.frag", "display.frag", NULL};
    row rows[MAX_ROWS];
    int count = 0;

    if (argc < 4 || argc % 3 != 1 || argc / 3 > MAX_ROWS)
        fail("NAME VERT.spv FRAG.spv ...", "usage");
    const gpu g = open_gpu();
    printf(
        "%s\n%-13s %6s %5s %5s %7s %6s %6s %6s %5s %4s %2s %3s %6s %5s %5s\n",
        g.about.deviceName, "", "instr.", "VGPRs", "waves", "latency", "busy",
        "ms", "once", "%", "cube", "2D", "buf", "ms", "bytes", "GB/s");
    for (int i = 1; i + 2 < argc; i += 3) {
        rows[count] = measure(&g, argv + i);
        print_row(&rows[count++]);
    }
    print_frame("spheres on all pixels", spheres, rows, count);
    print_frame("the room on all pixels", scene, rows, count);
    return 0;
}
