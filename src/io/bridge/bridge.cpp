// SPDX-License-Identifier: MIT
//
// OpenImageIO behind the C calls of bridge.h. It becomes a
// shared object of its own, because a program that links OpenImageIO takes
// 170 ms to start.
#include "io/bridge/bridge.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#define EXPORT extern "C" __attribute__((visibility("default")))

using namespace OIIO;

namespace
{
enum class storage {
    floats,
    counts,
    shorts,
    fractions
};
} // namespace

struct ibl_bridge {
    // Declared before input: the proxy must be destroyed after its reader.
    std::unique_ptr<Filesystem::IOMemReader> memory;
    std::unique_ptr<ImageInput> input;
    ImageSpec spec;
    int subimage = 0;
    int channel[3] = {0, 0, 0};
    int alpha = -1; // index of the alpha channel; -1: none
    storage kind = storage::floats;
    bool encoded = false;
    bool cube = false; // the faces lie below one another
    int x0 = 0, y0 = 0, width = 0, height = 0; // display window
    // Rows strip_y..strip_end-1 of the data window, channels first..last.
    std::vector<float> strip;
    int first = 0, last = 0;
    int strip_y = 0, strip_end = 0;
    std::vector<float> table; // linear values of 16-bit sRGB
};

namespace
{

const int strip_rows = 64;

// ThreadSanitizer cannot see the synchronisation of OpenImageIO's task queue,
// which is not built for it.
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define ONE_THREAD 1
#endif
#endif
#if defined(__SANITIZE_THREAD__)
#define ONE_THREAD 1
#endif
int threads_of(const ibl_bridge_request &request)
{
#ifdef ONE_THREAD
    (void)request;
    return 1;
#else
    return request.threads;
#endif
}

struct failure {
    ibl_bridge_result result;
    std::string text;
};

void say(char *message, const std::string &text)
{
    std::snprintf(message, IBL_BRIDGE_MESSAGE, "%s", text.c_str());
    for (char *c = message; *c; c++) {
        if (static_cast<unsigned char>(*c) < ' ')
            *c = ' ';
    }
}

// Runs f and converts exceptions to a result and a message.
template <typename F> ibl_bridge_result guarded(char *message, F f)
{
    try {
        message[0] = 0;
        f();
        return IBL_BRIDGE_OK;
    } catch (const failure &e) {
        say(message, e.text);
        return e.result;
    } catch (const std::bad_alloc &) {
        return IBL_BRIDGE_MEMORY;
    } catch (const std::length_error &) {
        return IBL_BRIDGE_MEMORY;
    } catch (const std::exception &e) {
        say(message, e.what());
        return IBL_BRIDGE_FORMAT;
    } catch (...) {
        say(message, "unknown exception");
        return IBL_BRIDGE_FORMAT;
    }
}

std::string complaint(ImageInput &input, const char *otherwise)
{
    std::string text = input.geterror();
    return text.empty() ? otherwise : text;
}

// Asks for colours as stored, not premultiplied.
ImageSpec hints(ibl_bridge &b)
{
    ImageSpec config;
    config["oiio:UnassociatedAlpha"] = 1;
    if (b.memory) {
        void *proxy = b.memory.get();
        config.attribute("oiio:ioproxy", TypeDesc::PTR, &proxy);
    }
    return config;
}

void open_as(ibl_bridge &b, const ibl_bridge_request &r, const char *reader)
{
    b.input = ImageInput::create(reader);
    if (!b.input) {
        geterror();
        throw failure{IBL_BRIDGE_UNKNOWN,
                      std::string("this OpenImageIO has no reader for ") +
                          reader};
    }
    std::string path = "memory";
    if (r.path) {
        path = r.path;
    } else if (b.input->supports("ioproxy")) {
        b.memory.reset(new Filesystem::IOMemReader(
            const_cast<unsigned char *>(r.bytes), r.size));
    } else {
        throw failure{IBL_BRIDGE_NEEDS_FILE, ""};
    }
    b.input->threads(threads_of(r));
    if (!b.input->open(path, b.spec, hints(b)))
        throw failure{IBL_BRIDGE_FORMAT,
                      complaint(*b.input, "its header cannot be read")};
}

// Tries all readers except those that accept anything (films, text terminals,
// raw volumes) or whose files are not pictures of the world.
void open_any(ibl_bridge &b, const ibl_bridge_request &r)
{
    static const char *const unwanted[] = {"ffmpeg", "null",  "term", "openvdb",
                                           "ptex",   "dicom", "ico",  "zfile"};
    if (!r.path)
        throw failure{IBL_BRIDGE_NEEDS_FILE, ""};
    std::vector<std::string> names;
    Strutil::split(get_string_attribute("format_list"), names, ",");
    for (const std::string &name : names) {
        if (std::find(std::begin(unwanted), std::end(unwanted), name) !=
            std::end(unwanted))
            continue;
        try {
            open_as(b, r, name.c_str());
            return;
        } catch (const std::bad_alloc &) {
            throw;
        } catch (...) {
            b.input.reset();
            b.memory.reset();
        }
    }
    throw failure{IBL_BRIDGE_UNKNOWN, "no reader knows it"};
}

int find_channel(const ImageSpec &spec, const char *name)
{
    // Some readers (FITS) name fewer channels than they have.
    const int count = std::min(spec.nchannels, int(spec.channelnames.size()));
    for (int i = 0; i < count; i++) {
        if (spec.channelnames[size_t(i)] == name)
            return i;
    }
    for (int i = 0; i < count; i++) {
        if (Strutil::iequals(spec.channelnames[size_t(i)], name))
            return i;
    }
    return -1;
}

// Chooses the requested channels; else R, G, B by name, the first three, or
// three times the first.
void choose_channels(ibl_bridge &b, const ibl_bridge_request &r)
{
    static const char *const rgb[] = {"R", "G", "B"};
    if (b.spec.nchannels < 1)
        throw failure{IBL_BRIDGE_FORMAT, "it has no channels"};
    bool named = true;
    for (int c = 0; c < 3; c++) {
        b.channel[c] =
            find_channel(b.spec, r.channels[c] ? r.channels[c] : rgb[c]);
        named = named && b.channel[c] >= 0;
        if (r.channels[c] && b.channel[c] < 0)
            throw failure{IBL_BRIDGE_FORMAT,
                          std::string("no channel ") + r.channels[c]};
    }
    if (named)
        return;
    const bool grey = b.spec.nchannels < 3;
    for (int c = 0; c < 3; c++)
        b.channel[c] = grey ? 0 : c;
}

void choose_alpha(ibl_bridge &b, const ibl_bridge_request &r)
{
    if (!r.want_alpha)
        return;
    b.alpha = b.spec.alpha_channel >= 0 ? b.spec.alpha_channel
                                        : find_channel(b.spec, "A");
    if (b.alpha >= b.spec.nchannels)
        b.alpha = -1;
    for (int c = 0; c < 3; c++) {
        if (b.alpha == b.channel[c])
            b.alpha = -1;
    }
}

void seek(ibl_bridge &b)
{
    if (!b.input->seek_subimage(b.subimage, 0))
        throw failure{IBL_BRIDGE_FORMAT,
                      complaint(*b.input, "its part cannot be read")};
    b.spec = b.input->spec();
    if (b.spec.deep)
        throw failure{IBL_BRIDGE_FORMAT, "deep data has no one colour per "
                                         "pixel"};
    if (b.spec.get_int_attribute("tiff:PhotometricInterpretation") >> 1 ==
        32844 >> 1)
        throw failure{IBL_BRIDGE_FORMAT,
                      "LogLuv, of which OpenImageIO keeps 8 bits: convert it "
                      "to EXR"};
    if (b.spec.depth > 1)
        throw failure{IBL_BRIDGE_FORMAT, "it is a volume, not an image"};
}

// How the channels are stored. OpenEXR's uints are numbers; other integers are
// fractions of the largest.
storage storage_of(const ibl_bridge &b)
{
    const TypeDesc type = b.spec.channelformat(b.channel[0]);
    const bool exr = std::strcmp(b.input->format_name(), "openexr") == 0;
    for (int c = 1; c < (b.alpha < 0 ? 3 : 4); c++) {
        const TypeDesc other =
            b.spec.channelformat(c < 3 ? b.channel[c] : b.alpha);
        if (other.is_floating_point() != type.is_floating_point())
            throw failure{IBL_BRIDGE_FORMAT,
                          "its channels are partly integers"};
    }
    if (type.is_floating_point())
        return storage::floats;
    if (exr)
        return storage::counts;
    return type == TypeDesc::UINT8 || type == TypeDesc::UINT16
               ? storage::shorts
               : storage::fractions;
}

void describe(const ibl_bridge &b, ibl_bridge_info *info)
{
    *info = ibl_bridge_info();
    info->width = b.width;
    info->height = b.height;
    info->data_width = b.spec.width;
    info->data_height = b.spec.height;
    info->raw_bytes = double(b.spec.width) * double(b.spec.height) *
                      double(b.spec.pixel_bytes(true));
    info->low_range = b.kind == storage::shorts || b.kind == storage::fractions
                          ? 1 + int(b.encoded)
                          : 0;
    info->orientation = b.spec.get_int_attribute("Orientation", 1);
    info->cube = b.cube;
    info->has_alpha = b.alpha >= 0;
    // The reader sets it if the colours are straight and it obeyed the hint.
    info->straight = b.spec.get_int_attribute("oiio:UnassociatedAlpha") != 0;
    std::snprintf(info->format, sizeof info->format, "%s, %s",
                  b.input->format_name(),
                  b.spec.channelformat(b.channel[0]).c_str());
}

// The sRGB decoding of IEC 61966-2-1.
double srgb_to_linear(double v)
{
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

// The visible pixels of the data window.
struct placement {
    int x0, x1, y0, y1; // excluding x1 and y1
};

placement place(const ibl_bridge &b)
{
    placement p;
    p.x0 = std::max(b.spec.x, b.x0);
    p.x1 = int(
        std::min(int64_t(b.spec.x) + b.spec.width, int64_t(b.x0) + b.width));
    p.y0 = std::max(b.spec.y, b.y0);
    p.y1 = int(
        std::min(int64_t(b.spec.y) + b.spec.height, int64_t(b.y0) + b.height));
    return p;
}

// Reads rows y0..y1-1 of the data window into the strip.
void read_rows(ibl_bridge &b, int y0, int y1)
{
    const TypeDesc type =
        b.kind == storage::counts ? TypeDesc::UINT32 : TypeDesc::FLOAT;
    ImageInput &in = *b.input;
    const ImageSpec &s = b.spec;
    const bool ok =
        s.tile_width > 0
            ? in.read_tiles(b.subimage, 0, s.x, s.x + s.width, y0, y1, s.z,
                            s.z + 1, b.first, b.last + 1, type, b.strip.data())
            : in.read_scanlines(b.subimage, 0, y0, y1, s.z, b.first, b.last + 1,
                                type, b.strip.data());
    if (!ok)
        throw failure{IBL_BRIDGE_FORMAT,
                      complaint(in, "its pixels cannot be read")};
}

// Converts a sample of the strip to the value that it represents.
float convert(const ibl_bridge &b, float v, bool is_alpha)
{
    uint32_t count;
    switch (b.kind) {
    case storage::counts: // v holds the bits of an integer
        std::memcpy(&count, &v, sizeof count);
        return float(count);
    case storage::shorts: {
        // 8 bits widen to 16 exactly: v * 257 / 65535 = v / 255.
        const int n = int(v * 65535 + 0.5f);
        return is_alpha || b.encoded ? float(n) / 65535 : b.table[size_t(n)];
    }
    case storage::fractions:
        return is_alpha || b.encoded ? v : float(srgb_to_linear(double(v)));
    case storage::floats:
        break;
    }
    return v;
}

// Reads the strip that contains row y of the data window; in tiled files a
// strip is whole rows of tiles.
void load_strip(ibl_bridge &b, int y)
{
    const int tile = std::max(b.spec.tile_height, 1);
    const int rows = (strip_rows + tile - 1) / tile * tile;
    const int begin = b.spec.y + (y - b.spec.y) / rows * rows;
    const int end = std::min(begin + rows, b.spec.y + b.spec.height);
    const int step = b.last - b.first + 1;

    b.strip_y = b.strip_end = 0;
    b.strip.resize(size_t(step) * size_t(b.spec.width) *
                   size_t(std::min(rows, b.spec.height)));
    read_rows(b, begin, end);
    if (b.kind != storage::floats) {
        for (size_t i = 0; i < b.strip.size();)
            for (int c = 0; c < step; c++, i++)
                b.strip[i] = convert(b, b.strip[i], b.first + c == b.alpha);
    }
    b.strip_y = begin;
    b.strip_end = end;
}

void read_map(ibl_bridge &b, int row, int rows, float *rgb, float *alpha)
{
    const placement p = place(b);
    const int step = b.last - b.first + 1;

    for (int y = b.y0 + row; y < b.y0 + row + rows; y++) {
        const size_t before = size_t(y - b.y0 - row) * size_t(b.width);
        float *dst = rgb + 3 * before;
        float *a = alpha ? alpha + before : nullptr;
        if (p.x1 - p.x0 < b.width || y < p.y0 || y >= p.y1) {
            std::fill_n(dst, 3 * size_t(b.width), 0.0f);
            if (a)
                std::fill_n(a, size_t(b.width), 0.0f);
        }
        if (y < p.y0 || y >= p.y1)
            continue;
        if (y < b.strip_y || y >= b.strip_end)
            load_strip(b, y);
        const float *src =
            b.strip.data() +
            size_t(step) * (size_t(y - b.strip_y) * size_t(b.spec.width) +
                            size_t(p.x0 - b.spec.x));
        dst += 3 * size_t(p.x0 - b.x0);
        for (int x = p.x0; x < p.x1; x++, src += step, dst += 3) {
            for (int c = 0; c < 3; c++)
                dst[c] = src[b.channel[c] - b.first];
            if (a)
                a[x - b.x0] = src[b.alpha - b.first];
        }
    }
}

} // namespace

EXPORT int ibl_bridge_abi(void)
{
    return IBL_BRIDGE_ABI;
}

EXPORT ibl_bridge_result ibl_bridge_open(const ibl_bridge_request *request,
                                         ibl_bridge **bridge,
                                         ibl_bridge_info *info, char *message)
{
    *bridge = nullptr;
    return guarded(message, [&] {
        std::unique_ptr<ibl_bridge> b(new ibl_bridge);
        attribute("threads", threads_of(*request));
        attribute("exr_threads", -1); // none of OpenEXR's own
        attribute("try_all_readers", 0);
        if (request->reader)
            open_as(*b, *request, request->reader);
        else
            open_any(*b, *request);
        b->subimage = request->subimage;
        seek(*b);
        choose_channels(*b, *request);
        choose_alpha(*b, *request);
        b->kind = storage_of(*b);
        b->encoded = request->encoded > 0;
        if (request->encoded < 0)
            b->encoded = Strutil::iequals(
                b->spec.get_string_attribute("oiio:ColorSpace"), "linear");
        b->first = *std::min_element(b->channel, b->channel + 3);
        b->last = *std::max_element(b->channel, b->channel + 3);
        if (b->alpha >= 0) {
            b->first = std::min(b->first, b->alpha);
            b->last = std::max(b->last, b->alpha);
        }
        for (int i = 0; i < 65536 && b->kind == storage::shorts; i++)
            b->table.push_back(float(srgb_to_linear(i / 65535.0)));
        b->x0 = b->spec.full_x;
        b->y0 = b->spec.full_y;
        b->width = b->spec.full_width;
        b->height = b->spec.full_height;
        b->cube = b->spec.get_string_attribute("textureformat") ==
                      "CubeFace Environment" &&
                  !std::strcmp(b->input->format_name(), "dds");
        if (b->cube) {
            b->x0 = b->spec.x;
            b->y0 = b->spec.y;
            b->width = b->spec.width;
            b->height = b->spec.height;
        }
        const placement p = place(*b);
        if (b->spec.width < 1 || b->spec.height < 1 || p.x1 <= p.x0 ||
            p.y1 <= p.y0)
            throw failure{IBL_BRIDGE_FORMAT,
                          "its data lies outside its display window"};
        describe(*b, info);
        *bridge = b.release();
    });
}

EXPORT ibl_bridge_result ibl_bridge_read(ibl_bridge *bridge, int first,
                                         int rows, float *rgb, float *alpha,
                                         char *message)
{
    return guarded(message, [&] {
        read_map(*bridge, first, rows, rgb,
                 bridge->alpha < 0 ? nullptr : alpha);
    });
}

EXPORT void ibl_bridge_close(ibl_bridge *bridge)
{
    try {
        if (bridge && bridge->input)
            bridge->input->close();
        delete bridge;
    } catch (...) {
    }
}
