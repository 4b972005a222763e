// Baked geometry: static surfaces as one checked binary file that is read without building
// anything.
#pragma once

#include "server/physics/shapes/heightfield.h"
#include "server/physics/shapes/mesh.h"
#include "server/physics/shapes/shape.h"
#include "shared/core/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace zoned::assets {

// A baked file, all numbers little endian:
//
//   offset  bytes
//        0      8  "ZONEDGEO"
//        8      4  version, kBakedVersion
//       12      4  kind: 1 mesh, 2 heightfield
//       16      8  length of the body in bytes
//       24     32  SHA-256 (FIPS 180-4) of the 24 bytes before it and of the body
//       56         body
//
// Body of a mesh of V vertices, T triangles, N nodes:
//   u32 V, T, N, zero
//   V x 3 f32       vertices, m
//   T x 3 u32       corners, counter-clockwise seen from the front
//   T x 3 x 2 f32   bends: cosine and sine at each edge (see EdgeBend)
//   T x u32         the triangles in the order of the tree's leaves
//   N x u8          the tree, depth first: 0 inner node, else a leaf of so many triangles
//
// Body of a heightfield (see Heightfield):
//   u32 columns, rows
//   f32 spacing_x, spacing_z, thickness, m
//   columns x rows f32   heights, row by row, m
//
// Normals, and the boxes of the tree, follow from the rest in a moment: they are computed when the
// file is read, which leaves nothing that could contradict.

inline constexpr std::array<char, 8> kBakedMagic{'Z', 'O', 'N', 'E', 'D', 'G', 'E', 'O'};
inline constexpr std::uint32_t kBakedVersion = 1;
inline constexpr std::size_t kBakedSumAt = 24;
inline constexpr std::size_t kBakedBodyAt = 56;

/// The bytes of a baked file. The same geometry gives the same bytes.
std::string bake(const physics::TriangleMesh& mesh);
std::string bake(const physics::Heightfield& field);
/// Of a shape of kind kMesh or kHeightfield.
std::string bake(const physics::Shape& shape);

/// Whether the bytes begin as those of a baked file do.
bool is_baked(std::string_view bytes);

/// The shape of kind kMesh or kHeightfield in a baked file: it answers as the shape that was baked,
/// bit for bit. The bytes may be any: sizes are checked before memory is asked for. A file that is
/// damaged, cut short or of another version is refused with the reason.
core::Result<physics::Shape> read_baked(std::string_view bytes);

/// Writes a matching checksum over the one in the bytes (at least kBakedBodyAt of them): for tests
/// of the checks behind it.
void seal_baked(std::string& bytes);

/// Empty when both hold the same geometry bit for bit, otherwise which table differs.
std::string difference_of(const physics::Shape& a, const physics::Shape& b);

}  // namespace zoned::assets
