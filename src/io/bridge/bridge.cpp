// SPDX-License-Identifier: MIT
//
// OpenImageIO behind the C call of bridge.h. It becomes a shared object of its
// own, because a program that links OpenImageIO takes 170 ms to start.
#include "io/bridge/bridge.h"

#include <algorithm>
#include <cerrno>
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

using namespace OIIO;

namespace
{

// Rows that are read at once, or one row of tiles.
const int strip_rows = 64;

// ThreadSanitizer cannot see the synchronisation of OpenImageIO's task queue,
// which is not built for it.
#ifndef IBL_TSAN
#define IBL_TSAN 0
#endif
int threads_of(const ibl_bridge_request &request)
{
    return IBL_TSAN ? 1 : request.threads;
}

using failure = std::runtime_error;

struct stopped {
};

enum class storage {
    floats,
    shorts,
    fractions
};

struct picture {
    // Declared before input: the proxy must be destroyed after its reader.
    std::unique_ptr<Filesystem::IOMemReader> memory;
    FILE *file = nullptr;
    std::unique_ptr<ImageInput> input;
    ImageSpec spec;
    int channel[3] = {0, 0, 0};
    int alpha = -1; // index of the alpha channel; -1: none
    storage kind = storage::floats;
    bool encoded = false;
    std::vector<float> table; // linear values of 16-bit sRGB

    ~picture()
    {
        if (file)
            std::fclose(file);
    }
};

std::string complaint(ImageInput &input, const char *otherwise)
{
    std::string text = input.geterror();
    return text.empty() ? otherwise : text;
}

void open(picture &p, const ibl_bridge_request &r)
{
    ImageSpec config;
    std::string path = "memory";

    p.input = ImageInput::create(r.reader);
    if (!p.input) {
        geterror();
        throw failure(std::string("this OpenImageIO has no reader for ") +
                      r.reader);
    }
    config["oiio:UnassociatedAlpha"] = 1; // colours as stored
    if (p.input->supports("ioproxy")) {
        p.memory.reset(new Filesystem::IOMemReader(
            const_cast<unsigned char *>(r.bytes), r.size));
        void *proxy = p.memory.get();
        config.attribute("oiio:ioproxy", TypeDesc::PTR, &proxy);
    } else { // a file without a name, so that nothing stays behind
        p.file = std::tmpfile();
        if (!p.file || std::fwrite(r.bytes, 1, r.size, p.file) != r.size ||
            std::fflush(p.file))
            throw failure(std::string("no temporary file: ") +
                          std::strerror(errno));
        path = "/dev/fd/" + std::to_string(fileno(p.file));
    }
    p.input->threads(threads_of(r));
    if (!p.input->open(path, p.spec, config))
        throw failure(complaint(*p.input, "its header cannot be read"));
    p.spec = p.input->spec();
    if (p.spec.get_int_attribute("tiff:PhotometricInterpretation") >> 1 ==
        32844 >> 1)
        throw failure("LogLuv, of which OpenImageIO keeps 8 bits: convert it "
                      "to EXR");
    if (p.spec.depth > 1)
        throw failure("it is a volume, not an image");
    if (p.spec.nchannels < 1)
        throw failure("it has no channels");
}

int find_channel(const ImageSpec &spec, const char *name)
{
    // Some readers (FITS) name fewer channels than they have.
    const int count = std::min(spec.nchannels, int(spec.channelnames.size()));
    for (int i = 0; i < count; i++)
        if (Strutil::iequals(spec.channelnames[size_t(i)], name))
            return i;
    return -1;
}

// Chooses the requested channels; else R, G, B by name, the first three, or
// three times the first. Finds how they are stored: integers are fractions of
// the largest.
void choose_channels(picture &p, const ibl_bridge_request &r)
{
    static const char *const rgb[] = {"R", "G", "B"};
    const ImageSpec &s = p.spec;
    bool named = true;

    for (int c = 0; c < 3; c++) {
        p.channel[c] = find_channel(s, rgb[c]);
        named = named && p.channel[c] >= 0;
    }
    for (int c = 0; c < 3 && !named; c++)
        p.channel[c] = s.nchannels < 3 ? 0 : c;
    if (r.want_alpha)
        p.alpha = s.alpha_channel >= 0 ? s.alpha_channel : find_channel(s, "A");
    if (p.alpha >= s.nchannels ||
        std::count(p.channel, p.channel + 3, p.alpha) > 0)
        p.alpha = -1;

    const TypeDesc type = s.channelformat(p.channel[0]);
    for (int c : {p.channel[1], p.channel[2], p.alpha})
        if (c >= 0 &&
            s.channelformat(c).is_floating_point() != type.is_floating_point())
            throw failure("its channels are partly integers");
    if (!type.is_floating_point())
        p.kind = type == TypeDesc::UINT8 || type == TypeDesc::UINT16
                     ? storage::shorts
                     : storage::fractions;
    p.encoded =
        r.encoded > 0 ||
        (r.encoded < 0 &&
         Strutil::iequals(s.get_string_attribute("oiio:ColorSpace"), "linear"));
}

// The sRGB decoding of IEC 61966-2-1.
double srgb_to_linear(double v)
{
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

// Converts a sample to the value that it represents.
float convert(const picture &p, float v, bool is_alpha)
{
    const bool linear = is_alpha || p.encoded;
    switch (p.kind) {
    case storage::shorts: {
        // 8 bits widen to 16 exactly: v * 257 / 65535 = v / 255.
        const int n = int(v * 65535 + 0.5f);
        return linear ? float(n) / 65535 : p.table[size_t(n)];
    }
    case storage::fractions:
        return linear ? v : float(srgb_to_linear(double(v)));
    case storage::floats:
        break;
    }
    return v;
}

ibl_bridge_info describe(const picture &p)
{
    const ImageSpec &s = p.spec;
    ibl_bridge_info info = {};

    info.cube =
        s.get_string_attribute("textureformat") == "CubeFace Environment" &&
        !std::strcmp(p.input->format_name(), "dds");
    info.width = s.width;
    info.height = s.height;
    info.raw_bytes =
        double(s.width) * double(s.height) * double(s.pixel_bytes(true));
    info.low_range = p.kind == storage::shorts || p.kind == storage::fractions
                         ? 1 + int(p.encoded)
                         : 0;
    info.orientation = s.get_int_attribute("Orientation", 1);
    info.has_alpha = p.alpha >= 0;
    // The reader sets it if the colours are straight and it obeyed the hint.
    info.straight = s.get_int_attribute("oiio:UnassociatedAlpha") != 0;
    std::snprintf(info.format, sizeof info.format, "%s, %s",
                  p.input->format_name(),
                  s.channelformat(p.channel[0]).c_str());
    return info;
}

// Reads the pixels in strips.
void read(picture &p, const ibl_bridge_request &r)
{
    const ibl_bridge_info info = describe(p);
    const ImageSpec &s = p.spec;
    const int tile = std::max(s.tile_height, 1);
    const int rows = (strip_rows + tile - 1) / tile * tile;
    const auto ends = std::minmax({p.channel[0], p.channel[1], p.channel[2],
                                   p.alpha < 0 ? p.channel[0] : p.alpha});
    const int first = ends.first, step = ends.second - first + 1;
    float *rgb = nullptr, *alpha = nullptr;
    std::vector<float> strip;

    if (s.width < 1 || s.height < 1)
        throw failure("it has no pixels");
    if (!r.begin(r.user, &info, &rgb, &alpha))
        throw stopped();
    for (int i = 0; i < 65536 && p.kind == storage::shorts; i++)
        p.table.push_back(float(srgb_to_linear(i / 65535.0)));
    strip.resize(size_t(step) * size_t(s.width) *
                 size_t(std::min(rows, s.height)));
    for (int y = 0; y < s.height; y += rows) {
        const int begin = s.y + y, end = s.y + std::min(y + rows, s.height);
        const bool ok =
            s.tile_width > 0
                ? p.input->read_tiles(0, 0, s.x, s.x + s.width, begin, end, s.z,
                                      s.z + 1, first, first + step,
                                      TypeDesc::FLOAT, strip.data())
                : p.input->read_scanlines(0, 0, begin, end, s.z, first,
                                          first + step, TypeDesc::FLOAT,
                                          strip.data());
        if (!ok)
            throw failure(complaint(*p.input, "its pixels cannot be read"));
        const float *from = strip.data();
        for (size_t i = 0; i < size_t(end - begin) * size_t(s.width); i++) {
            for (int c = 0; c < 3; c++)
                *rgb++ = convert(p, from[p.channel[c] - first], false);
            if (p.alpha >= 0)
                *alpha++ = convert(p, from[p.alpha - first], true);
            from += step;
        }
        if (!r.go_on(r.user))
            throw stopped();
    }
}

} // namespace

extern "C" __attribute__((visibility("default"))) ibl_bridge_result
ibl_bridge_read_9(const ibl_bridge_request *request, char *message)
{
    *message = '\0';
    try {
        picture p;
        attribute("threads", threads_of(*request));
        attribute("exr_threads", -1); // none of OpenEXR's own
        open(p, *request);
        choose_channels(p, *request);
        read(p, *request);
        p.input->close();
        return IBL_BRIDGE_OK;
    } catch (const stopped &) {
        return IBL_BRIDGE_STOPPED;
    } catch (const std::bad_alloc &) {
        return IBL_BRIDGE_MEMORY;
    } catch (const std::length_error &) {
        return IBL_BRIDGE_MEMORY;
    } catch (const std::exception &x) {
        std::snprintf(message, IBL_BRIDGE_MESSAGE, "%s", x.what());
    } catch (...) {
        std::snprintf(message, IBL_BRIDGE_MESSAGE, "unknown exception");
    }
    for (char *c = message; *c; c++)
        if (static_cast<unsigned char>(*c) < ' ')
            *c = ' ';
    return IBL_BRIDGE_FORMAT;
}
