// MotionBits: what clients compute of motion, as rows of numbers, for a comparison of builds.
#pragma once

#include <array>
#include <string_view>
#include <vector>

namespace zoned::testing_web {

/// Subjects whose numbers must be the same bits in each build.
inline constexpr std::array<std::string_view, 19> kSubjects = {
    "walk on boxes",    "walk on a surface",    "walk through doors",  "static positions",
    "linear positions", "quadratic positions",  "ballistic positions", "landing times",
    "snap positions",   "linear blends",        "projective blends",   "hermite blends",
    "quantised states", "turning positions",    "orientations",        "blended turns",
    "upright states",   "elementary functions", "walk on platforms",
};

/// The numbers of a subject.
std::vector<float> numbers_of(std::size_t subject);

}  // namespace zoned::testing_web
