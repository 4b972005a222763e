// Prints the state hashes of fixed scenarios; fails where the number of threads makes a difference.
#include "tests/determinism/hashes.h"

#include <cstdio>
#include <exception>

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

int run() {
    std::vector<Line> lines = physics_lines(1);
    const std::vector<Line> valley = valley_lines(1);
    bool good = true;
    for (const unsigned threads : {2U, 4U}) {
        good = same(lines, physics_lines(threads), threads) && good;
        good = same(valley, valley_lines(threads), threads) && good;
    }
    lines.insert(lines.end(), valley.begin(), valley.end());
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
