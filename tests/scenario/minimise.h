// minimise: the smallest part of something that fails.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace zoned::scenario {

/// A smallest subset of 0..count-1 that still fails, where no single element can be left out: the
/// minimising delta debugging of Zeller and Hildebrandt, "Simplifying and isolating
/// failure-inducing input", IEEE Trans. Software Eng. 28(2), 2002. `fails` gets ascending indices;
/// all of them together fail. It is called at most `budget` times, and `budget` counts down.
std::vector<std::size_t> minimise(std::size_t count,
                                  const std::function<bool(const std::vector<std::size_t>&)>& fails,
                                  int& budget);

}  // namespace zoned::scenario
