// Geometry files: heightfields from PNG images and meshes from Wavefront OBJ.
#pragma once

#include "server/assets/obj_scan.h"
#include "server/physics/shapes/heightfield.h"
#include "server/physics/shapes/mesh.h"
#include "shared/core/result.h"

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::assets {

/// Files larger than this are refused, bytes.
inline constexpr std::size_t kMaxGeometryFile = 256U << 20;

/// All bytes of a file, at most kMaxGeometryFile. The reason names the file.
core::Result<std::string> read_geometry_file(const std::string& path);

/// The kind of a file, by its first bytes and not by its name.
enum class GeometryContent {
    kPng,
    kBaked,
    kText,     ///< presumably an OBJ
    kUnknown,  ///< bytes that are no text
};

GeometryContent content_of(std::string_view bytes);

/// A greyscale PNG of 8 or 16 bits. Colour, palettes and transparency are refused. Column x of row
/// z is the sample there: black is 0 and white is `height` metres above it, plus `options.offset`.
/// Columns, rows and scale of the options are set from the image. Samples are values, not light: no
/// gamma is applied. The reason of a failure begins with "heightfield" and names the row where the
/// image is broken.
core::Result<std::shared_ptr<const physics::Heightfield>>
heightfield_from_png(std::span<const std::byte> bytes, float height, physics::FieldOptions options);

/// Bits of a sample of a PNG that was read, 8 for fewer: heights come in 2^bits - 1 steps.
unsigned png_bits(std::string_view bytes);

/// The scan of an OBJ without mistakes. Fails with how many there are, and the first of them with
/// their lines.
core::Result<ObjScan> good_obj(std::string_view text);

/// Its vertices times `scale`, m. Fails with the line of one that lies too far out.
core::Result<std::vector<Vec3>> scaled_vertices(const ObjScan& scan, float scale);

/// A Wavefront OBJ: all faces of all groups, polygons cut into triangles, materials ignored (no
/// other file is opened). Coordinates are taken times `scale`, in metres. The reason of a failure
/// begins with "mesh" and names the line where there is one; of several mistakes it tells the first
/// (scan_obj finds them all).
core::Result<physics::BuiltMesh> mesh_from_obj(std::string_view text,
                                               float scale,
                                               const physics::MeshOptions& options);

/// The same where the text has been scanned, and found good, already.
core::Result<physics::BuiltMesh> mesh_from_scanned(const ObjScan& scan,
                                                   float scale,
                                                   const physics::MeshOptions& options);

}  // namespace zoned::assets
