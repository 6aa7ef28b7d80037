// SPDX-License-Identifier: MIT
// OpenEXR's C++ library behind a C interface. A block that has not the place
// and size in both libraries is refused.
#include "io/bridge/openexr.h"

#include <memory>

#include <OpenEXR/Iex.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfTiledInputPart.h>

namespace
{
class stream : public Imf::IStream
{
  public:
    stream(ibl_openexr_read *by, const void *of, uint64_t bytes)
        : IStream("input"), fetch(by), cookie(of), size(bytes)
    {
    }
    bool read(char *to, int count) override
    {
        if (count < 0 || at > size || uint64_t(count) > size - at ||
            !fetch(cookie, at, size_t(count), to))
            throw Iex::InputExc("cut short");
        at += uint64_t(count);
        return at < size;
    }
    uint64_t tellg() override
    {
        return at;
    }
    void seekg(uint64_t to) override
    {
        at = to;
    }

  private:
    ibl_openexr_read *fetch;
    const void *cookie;
    uint64_t size, at = 0;
};
} // namespace

struct ibl_openexr_file {
    stream in;
    Imf::MultiPartInputFile file;
    const Imf::Header &header;
    std::unique_ptr<Imf::TiledInputPart> tiles;
    std::unique_ptr<Imf::InputPart> lines;

    ibl_openexr_file(ibl_openexr_read *read, const void *cookie, uint64_t size,
                     int part, int tiled)
        : in(read, cookie, size), file(in, 0, false), header(file.header(part))
    {
        if (tiled)
            tiles.reset(new Imf::TiledInputPart(file, part));
        else
            lines.reset(new Imf::InputPart(file, part));
    }
};

static ibl_openexr_file *open_part(ibl_openexr_read *read, const void *cookie,
                                   uint64_t size, int part, int tiled)
{
    try {
        return new ibl_openexr_file(read, cookie, size, part, tiled);
    } catch (...) {
        return nullptr;
    }
}

static size_t bytes_of(const Imf::Channel &channel)
{
    if (channel.xSampling != 1 || channel.ySampling != 1)
        throw Iex::InputExc("subsampled");
    return channel.type == Imf::HALF ? 2 : 4;
}

static void unpack_to(ibl_openexr_file &f, const Imath::Box2i &box,
                      size_t width, char *pixels, size_t bytes)
{
    const Imath::Box2i &data = f.header.dataWindow();
    const Imf::ChannelList &channels = f.header.channels();
    Imath::Box2i expected = data;
    Imf::FrameBuffer frame;
    size_t line = 0;
    int column = 0, row = 0;

    expected.min.y = box.min.y;
    expected.max.y = box.max.y;
    if (f.tiles) {
        column = (box.min.x - data.min.x) / int(f.tiles->tileXSize());
        row = (box.min.y - data.min.y) / int(f.tiles->tileYSize());
        expected = f.tiles->dataWindowForTile(column, row);
    }
    for (auto c = channels.begin(); c != channels.end(); ++c)
        line += bytes_of(c.channel()) * width;
    if (box != expected || line * (size_t(box.size().y) + 1) != bytes)
        throw Iex::InputExc("another size");
    for (auto c = channels.begin(); c != channels.end(); ++c) {
        const size_t size = bytes_of(c.channel());
        frame.insert(c.name(), Imf::Slice::Make(c.channel().type, pixels, box,
                                                size, line));
        pixels += width * size;
    }
    if (f.tiles) {
        f.tiles->setFrameBuffer(frame);
        f.tiles->readTile(column, row);
    } else {
        f.lines->setFrameBuffer(frame);
        f.lines->readPixels(box.min.y, box.max.y);
    }
}

static int unpack(ibl_openexr_file *file, int x, int y, int width, int height,
                  void *pixels, size_t bytes)
{
    try {
        const Imath::V2i first(x, y), last(x + width - 1, y + height - 1);
        unpack_to(*file, Imath::Box2i(first, last), size_t(width),
                  static_cast<char *>(pixels), bytes);
        return 1;
    } catch (...) {
        return 0;
    }
}

static void close_part(ibl_openexr_file *file)
{
    try {
        delete file;
    } catch (...) {
    }
}

extern "C" __attribute__((visibility("default"))) const ibl_openexr *
ibl_openexr_of(int abi)
{
    static const ibl_openexr calls = {open_part, unpack, close_part};
    return abi == IBL_OPENEXR_ABI ? &calls : nullptr;
}
