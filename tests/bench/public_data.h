// Public data: benchmarks by other authors, read from files that a machine may not have.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace zoned::bench {

/// Directory of the public data: the environment's ZONED_DATA, else shared/data beside the
/// repository.
std::string data_directory();

/// A world of 901 cubes at 60 Hz (G. Fiedler's problem of networked physics).
inline constexpr std::size_t kCubes = 901;

/// A cube as it is written: left_out, a, b, c, x, y, z, interacting.
using CubeRecord = std::array<std::int32_t, 8>;

/// The first `frames` frames of cubes901_`which` ("A" or "B"), kCubes records each. Fewer where the
/// file is shorter; none where it is missing or unreadable (`why` gives the reason).
std::vector<CubeRecord> read_cubes(const std::string& which, std::size_t frames, std::string& why);

}  // namespace zoned::bench
