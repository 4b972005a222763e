// Prints the state hashes of fixed scenarios; fails where the number of threads makes a difference.
#include "tests/determinism/hashes.h"

#include <cstdio>
#include <exception>
#include <span>
#include <string>
#include <utility>

namespace zoned::determinism {
namespace {

bool same(const std::vector<Line>& one, const std::vector<Line>& other, unsigned threads) {
    for (std::size_t i = 0; i < one.size() && i < other.size(); ++i) {
        if (one[i] != other[i]) {
            std::fprintf(stderr,
                         "%s, %s: %s with one thread, %s with %u\n",
                         one[i].scenario.c_str(),
                         one[i].moment.c_str(),
                         one[i].hash.c_str(),
                         other[i].hash.c_str(),
                         threads);
            return false;
        }
    }
    return one.size() == other.size();
}

/// Rigid bodies, networks, then worlds: rigid bodies and agents, soft bodies, cubes, particles, all
/// paths to decide, policies, joints.
std::vector<Line> all_lines(unsigned threads) {
    std::vector<Line> lines = elementary_lines();
    for (const std::vector<Line>& more : {physics_lines(threads), training_lines(threads)}) {
        lines.insert(lines.end(), more.begin(), more.end());
    }
    for (const auto& [world, bots] : {std::pair("valley", std::size_t{60}),
                                      {"cloth", 12},
                                      {"cubes", 4},
                                      {"weather", 12},
                                      {"hamlet", 12},
                                      {"learned", 12},
                                      {"machines", 12}}) {
        const std::vector<Line> more = world_lines(world, bots, threads);
        lines.insert(lines.end(), more.begin(), more.end());
    }
    return lines;
}

int run(std::span<const unsigned> numbers) {
    const std::vector<Line> lines = all_lines(numbers.front());
    bool good = true;
    for (const unsigned threads : numbers.subspan(1)) {
        good = same(lines, all_lines(threads), threads) && good;
    }
    for (const Line& line : lines) {
        std::printf(
            "%-20s %-16s %s\n", line.scenario.c_str(), line.moment.c_str(), line.hash.c_str());
    }
    return good ? 0 : 1;
}

}  // namespace
}  // namespace zoned::determinism

/// Usage: determinism_hashes [THREADS...], 1 2 4 without asking. One number is for comparison with
/// another build.
int main(int count, char** arguments) {
    try {
        std::vector<unsigned> threads;
        for (int i = 1; i < count; ++i) {
            threads.push_back(static_cast<unsigned>(std::stoul(arguments[i])));
        }
        if (threads.empty()) {
            threads = {1, 2, 4};
        }
        return zoned::determinism::run(threads);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "determinism_hashes: %s\n", error.what());
        return 1;
    }
}
