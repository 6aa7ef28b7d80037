// SPDX-License-Identifier: MIT
//
// OpenEXR's C++ library behind a C function. It unpacks whole files only, so it
// gets each block as the one tile of a file of that size: what a damaged header
// says does not reach it.
#include "io/bridge/openexr.h"

#include <sstream>

#include <OpenEXR/Iex.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfTiledInputFile.h>
#include <OpenEXR/ImfVersion.h>
#include <OpenEXR/ImfXdr.h>

static std::string file_of(const exr_attr_chlist_t *channels,
                           const exr_chunk_info_t *chunk, const void *packed)
{
    const int width = chunk->width, height = chunk->height;
    Imf::Header header(width, height);
    Imf::StdOSStream out;

    header.compression() = Imf::Compression(chunk->compression);
    header.setTileDescription(
        Imf::TileDescription(unsigned(width), unsigned(height)));
    for (int i = 0; i < channels->num_channels; i++)
        header.channels().insert(
            channels->entries[i].name.str,
            Imf::Channel(Imf::PixelType(channels->entries[i].pixel_type), 1, 1,
                         channels->entries[i].p_linear != 0));
    Imf::Xdr::write<Imf::StreamIO>(out, Imf::MAGIC);
    Imf::Xdr::write<Imf::StreamIO>(out, Imf::EXR_VERSION | Imf::TILED_FLAG);
    header.writeTo(out, true);
    Imf::Xdr::write<Imf::StreamIO>(out, out.tellp() + 8); // of the tile
    for (int i = 0; i < 4; i++)                           // where it lies
        Imf::Xdr::write<Imf::StreamIO>(out, 0);
    Imf::Xdr::write<Imf::StreamIO>(out, int(chunk->packed_size));
    out.write(static_cast<const char *>(packed), int(chunk->packed_size));
    return out.str();
}

static void unpack(const exr_attr_chlist_t *channels,
                   const exr_chunk_info_t *chunk, const void *packed,
                   char *pixels)
{
    Imf::StdISStream in;
    in.str(file_of(channels, chunk, packed));
    Imf::TiledInputFile file(in, 0);
    const size_t width = size_t(chunk->width);
    const Imf::ChannelList &all = file.header().channels();
    Imf::FrameBuffer frame;
    size_t line = 0;

    for (auto c = all.begin(); c != all.end(); ++c)
        line += width * (c.channel().type == Imf::HALF ? 2 : 4);
    if (line * size_t(chunk->height) != chunk->unpacked_size)
        throw Iex::InputExc("another size");
    for (auto c = all.begin(); c != all.end(); ++c) {
        const size_t size = c.channel().type == Imf::HALF ? 2 : 4;
        frame.insert(c.name(),
                     Imf::Slice(c.channel().type, pixels, size, line));
        pixels += width * size;
    }
    file.setFrameBuffer(frame);
    file.readTile(0, 0);
}

extern "C" __attribute__((visibility("default"))) int
ibl_openexr_unpack_1(const exr_attr_chlist_t *channels,
                     const exr_chunk_info_t *chunk, const void *packed,
                     void *pixels)
{
    try {
        unpack(channels, chunk, packed, static_cast<char *>(pixels));
        return 1;
    } catch (...) {
        return 0;
    }
}

extern "C" __attribute__((visibility("default"))) int
ibl_openexr_unpack_dwa_1(const exr_attr_chlist_t *channels,
                         const exr_chunk_info_t *chunk, const void *packed,
                         void *pixels)
{
    return ibl_openexr_unpack_1(channels, chunk, packed, pixels);
}
