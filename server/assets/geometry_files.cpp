#include "server/assets/geometry_files.h"

#include "server/assets/baked_geometry.h"
#include "server/physics/shapes/ranges.h"

#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>
#include <vector>

namespace zoned::assets {

namespace {

/// The input of libpng, and the place for its message. libpng reports errors by a long jump. A
/// function that it may leave so must hold nothing with a destructor.
struct PngReader {
    std::span<const std::byte> bytes;
    char message[128] = "";
    png_structp png = nullptr;
    png_infop info = nullptr;
    png_uint_32 width = 0, height = 0;
    int depth = 0, colour = 0;
    png_uint_32 rows = 0;  // read so far

    PngReader() = default;
    PngReader(const PngReader&) = delete;
    PngReader& operator=(const PngReader&) = delete;

    ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
};

void take_bytes(png_structp png, png_bytep out, std::size_t count) {
    auto* reader = static_cast<PngReader*>(png_get_io_ptr(png));
    if (count > reader->bytes.size()) {
        png_error(png, "ends too early");
    }
    std::memcpy(out, reader->bytes.data(), count);
    reader->bytes = reader->bytes.subspan(count);
}

[[noreturn]] void take_error(png_structp png, png_const_charp message) {
    auto* reader = static_cast<PngReader*>(png_get_error_ptr(png));
    std::strncpy(reader->message, message, sizeof(reader->message) - 1);
    png_longjmp(png, 1);
}

void count_row(png_structp png, png_uint_32 row, int /*pass*/) {
    static_cast<PngReader*>(png_get_io_ptr(png))->rows = row;
}

void ignore_warning(png_structp /*png*/, png_const_charp /*message*/) {
}

bool read_header(PngReader& reader) {
    if (setjmp(png_jmpbuf(reader.png)) != 0) {
        return false;
    }
    png_set_user_limits(reader.png, physics::kMaxFieldSamples, physics::kMaxFieldSamples);
    png_set_read_fn(reader.png, &reader, take_bytes);
    png_read_info(reader.png, reader.info);
    png_get_IHDR(reader.png,
                 reader.info,
                 &reader.width,
                 &reader.height,
                 &reader.depth,
                 &reader.colour,
                 nullptr,
                 nullptr,
                 nullptr);
    return true;
}

/// `rows` has one pointer for each row of the image.
bool read_rows(PngReader& reader, png_bytepp rows) {
    if (setjmp(png_jmpbuf(reader.png)) != 0) {
        return false;
    }
    if (reader.depth < 8) {
        png_set_expand_gray_1_2_4_to_8(reader.png);
    }
    png_set_read_status_fn(reader.png, count_row);
    png_set_interlace_handling(reader.png);
    png_read_update_info(reader.png, reader.info);
    png_read_image(reader.png, rows);
    return true;
}

const char* colour_name(int colour) {
    switch (colour) {
        case PNG_COLOR_TYPE_PALETTE:
            return "colours by a palette";
        case PNG_COLOR_TYPE_RGB:
            return "red, green and blue";
        case PNG_COLOR_TYPE_RGB_ALPHA:
            return "red, green, blue and transparency";
        case PNG_COLOR_TYPE_GRAY_ALPHA:
            return "grey and transparency";
        default:
            return "unknown samples";
    }
}

constexpr std::size_t kObjMistakesShown = 3;

constexpr std::size_t kPngDepthAt = 24;  // in the header that a PNG begins with

}  // namespace

core::Result<std::string> read_geometry_file(const std::string& path) {
    using Text = core::Result<std::string>;
    std::error_code none;
    if (std::filesystem::is_directory(path, none)) {
        return Text::failure(path + ": is a folder");
    }
    if (std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none)) {
        return Text::failure(path + ": is no regular file");  // a pipe would make us wait
    }
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    if (!in) {
        return Text::failure(path + ": cannot be opened");
    }
    const std::streamoff size = in.tellg();
    if (size < 0 || static_cast<std::size_t>(size) > kMaxGeometryFile) {
        return Text::failure(path + ": is larger than " + std::to_string(kMaxGeometryFile) +
                             " bytes");
    }
    std::string text(static_cast<std::size_t>(size), '\0');
    in.seekg(0);
    if (!in.read(text.data(), size)) {
        return Text::failure(path + ": cannot be read");
    }
    return text;
}

GeometryContent content_of(std::string_view bytes) {
    if (bytes.substr(0, 8) == "\x89PNG\r\n\x1a\n") {
        return GeometryContent::kPng;
    }
    if (is_baked(bytes)) {
        return GeometryContent::kBaked;
    }
    constexpr std::size_t kLook = 4096;
    const bool text = bytes.substr(0, kLook).find('\0') == std::string_view::npos;
    return text ? GeometryContent::kText : GeometryContent::kUnknown;
}

unsigned png_bits(std::string_view bytes) {
    return bytes.size() > kPngDepthAt && bytes[kPngDepthAt] == 16 ? 16 : 8;
}

core::Result<std::shared_ptr<const physics::Heightfield>> heightfield_from_png(
    std::span<const std::byte> bytes,
    float height,
    physics::FieldOptions options) {
    using Field = core::Result<std::shared_ptr<const physics::Heightfield>>;
    PngReader reader;
    reader.bytes = bytes;
    reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader, take_error, ignore_warning);
    reader.info = reader.png != nullptr ? png_create_info_struct(reader.png) : nullptr;
    if (reader.info == nullptr) {
        return Field::failure("heightfield: no memory to read the image");
    }
    if (!read_header(reader)) {
        return Field::failure("heightfield: is no PNG image: " + std::string(reader.message));
    }
    if (reader.colour != PNG_COLOR_TYPE_GRAY) {
        return Field::failure(
            std::string("heightfield: the image is not plain greyscale: it has ") +
            colour_name(reader.colour));
    }
    // Deflate makes of a byte no more than 1,032 (its specification, RFC 1951, allows no longer
    // matches): a short file asks for no large memory.
    const std::size_t row =
        (static_cast<std::size_t>(reader.width) * static_cast<std::size_t>(reader.depth) + 7) / 8;
    if (row * reader.height / 1032 > bytes.size()) {
        return Field::failure("heightfield: the image is broken: " + std::to_string(bytes.size()) +
                              " bytes cannot hold " + std::to_string(reader.width) + " x " +
                              std::to_string(reader.height) + " samples");
    }
    const std::size_t sample = reader.depth == 16 ? 2 : 1;
    const std::size_t stride = sample * reader.width;
    std::vector<png_byte> pixels(stride * reader.height);
    std::vector<png_bytep> rows(reader.height);
    for (std::size_t k = 0; k < rows.size(); ++k) {
        rows[k] = pixels.data() + k * stride;
    }
    if (!read_rows(reader, rows.data())) {
        return Field::failure("heightfield: the image is broken at row " +
                              std::to_string(reader.rows) + " of " + std::to_string(reader.height) +
                              ": " + reader.message);
    }
    std::vector<float> samples(static_cast<std::size_t>(reader.width) * reader.height);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        // Sixteen bits are stored with the high byte first.
        samples[i] = sample == 2
                         ? static_cast<float>(pixels[2 * i] * 256 + pixels[2 * i + 1]) / 65535.0F
                         : static_cast<float>(pixels[i]) / 255.0F;
    }
    options.columns = reader.width;
    options.rows = reader.height;
    options.scale = height;
    return physics::build_heightfield(samples, options);
}

core::Result<ObjScan> good_obj(std::string_view text) {
    ObjScan scan = scan_obj(text);
    if (scan.good()) {
        return scan;
    }
    std::string reason = "has " + std::to_string(scan.mistake_count) +
                         (scan.mistake_count == 1 ? " mistake" : " mistakes");
    for (std::size_t m = 0; m < scan.mistakes.size() && m < kObjMistakesShown; ++m) {
        reason += "; line " + std::to_string(scan.mistakes[m].line) + ": " + scan.mistakes[m].text;
    }
    return core::Result<ObjScan>::failure(reason + "; `zoned bake --check` tells all of an OBJ");
}

core::Result<std::vector<Vec3>> scaled_vertices(const ObjScan& scan, float scale) {
    std::vector<Vec3> vertices;
    vertices.reserve(scan.vertices.size());
    for (std::size_t i = 0; i < scan.vertices.size(); ++i) {
        vertices.push_back(scale * scan.vertices[i]);
        if (!physics::fit_position(vertices.back())) {
            return core::Result<std::vector<Vec3>>::failure(
                "mesh: line " + std::to_string(scan.vertex_lines[i]) +
                ": the vertex lies more than " +
                std::to_string(static_cast<int>(physics::kMaxCoordinate)) + " m out");
        }
    }
    return vertices;
}

core::Result<physics::BuiltMesh> mesh_from_scanned(const ObjScan& scan,
                                                   float scale,
                                                   const physics::MeshOptions& options) {
    const auto vertices = scaled_vertices(scan, scale);
    return vertices ? physics::build_mesh(*vertices, scan.indices, options)
                    : core::Result<physics::BuiltMesh>::failure(vertices.error());
}

core::Result<physics::BuiltMesh> mesh_from_obj(std::string_view text,
                                               float scale,
                                               const physics::MeshOptions& options) {
    const ObjScan scan = scan_obj(text);
    if (!scan.good()) {
        const ObjMistake& first = scan.mistakes.front();
        return core::Result<physics::BuiltMesh>::failure(
            "mesh: line " + std::to_string(first.line) + ": " + first.text);
    }
    return mesh_from_scanned(scan, scale, options);
}

}  // namespace zoned::assets
