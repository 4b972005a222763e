// Prints the state hashes of fixed scenarios; fails where the number of threads makes a difference.
#include "tests/determinism/hashes.h"

#include <cstdio>
#include <exception>
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
    std::vector<Line> lines = physics_lines(threads);
    const std::vector<Line> networks = training_lines(threads);
    lines.insert(lines.end(), networks.begin(), networks.end());
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

int run() {
    const std::vector<Line> lines = all_lines(1);
    bool good = true;
    for (const unsigned threads : {2U, 4U}) {
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

int main() {
    try {
        return zoned::determinism::run();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "determinism_hashes: %s\n", error.what());
        return 1;
    }
}
