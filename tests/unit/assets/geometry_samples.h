// Geometry samples: small images and meshes as the bytes of files.
#pragma once

#include <png.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace zoned::assets::test {

/// `format` is one of libpng's simplified interface, PNG_FORMAT_GRAY or PNG_FORMAT_LINEAR_Y.
inline std::vector<std::byte> png_of(std::uint32_t width,
                                     std::uint32_t height,
                                     png_uint_32 format,
                                     const void* pixels) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = width;
    image.height = height;
    image.format = format;
    png_alloc_size_t size = 0;
    png_image_write_to_memory(&image, nullptr, &size, 0, pixels, 0, nullptr);
    std::vector<std::byte> bytes(size);
    png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels, 0, nullptr);
    bytes.resize(size);
    return bytes;
}

/// Waves of n x n quadrilaterals, side metres wide, the first line of which is line 1.
inline std::string waves_obj(int n, double side) {
    std::string text;
    char line[120];
    for (int k = 0; k <= n; ++k) {
        for (int i = 0; i <= n; ++i) {
            const double x = side * (i / static_cast<double>(n) - 0.5);
            const double z = side * (k / static_cast<double>(n) - 0.5);
            const double y = 0.4 * std::sin(1.3 * x) * std::cos(1.1 * z);
            std::snprintf(line, sizeof(line), "v %.6f %.6f %.6f\n", x, y, z);
            text += line;
        }
    }
    for (int k = 0; k < n; ++k) {
        for (int i = 0; i < n; ++i) {
            const int a = k * (n + 1) + i + 1;
            std::snprintf(line, sizeof(line), "f %d %d %d %d\n", a, a + n + 1, a + n + 2, a + 1);
            text += line;
        }
    }
    return text;
}

}  // namespace zoned::assets::test
