// OBJ scan: vertices and triangles of a Wavefront OBJ, and every mistake in its text with the line.
#pragma once

#include "shared/math/types.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::assets {

/// More mistakes than this are counted, not described.
inline constexpr std::size_t kMaxObjMistakes = 100;

/// Faces of more corners are refused: cutting one up takes the cube of its corners at worst.
inline constexpr std::size_t kMaxObjCorners = 256;

struct ObjMistake {
    std::uint32_t line = 0;  ///< from 1
    std::string text;        ///< the mistake, to stand after the line
};

struct ObjScan {
    std::vector<Vec3> vertices;               ///< as they stand there, without a scale
    std::vector<std::uint32_t> vertex_lines;  ///< from 1
    std::uint32_t faces = 0;
    // Of all groups, polygons cut up; only valid when the scan is good.
    std::vector<std::uint32_t> indices;         ///< of vertices, three for each triangle
    std::vector<std::uint32_t> triangle_lines;  ///< from 1
    std::vector<ObjMistake> mistakes;           ///< the first of them, in order of line
    std::uint64_t mistake_count = 0;

    [[nodiscard]] bool good() const { return mistake_count == 0; }
};

/// Reads the words that matter for a surface (v, f) and checks them. Numbers are numbers, finite,
/// and rounded to the nearest float. Faces have 3..kMaxObjCorners corners and do not cross
/// themselves. Each corner names a vertex (counted from 1, or from -1 backwards) that stands
/// somewhere in the file. There are no more than physics::kMaxMeshTriangles. Points and lines are
/// checked alike and left out; materials and other files are not looked at. Words of the format
/// without meaning for the surface are skipped. Free-form surfaces and unknown words are mistakes.
/// (Wavefront, "Object files (.obj)", Advanced Visualizer manual, appendix B1.)
ObjScan scan_obj(std::string_view text);

}  // namespace zoned::assets
