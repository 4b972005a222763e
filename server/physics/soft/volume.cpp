#include "server/physics/soft/volume.h"

#include <algorithm>
#include <utility>

namespace zoned::physics::soft {

bool is_closed(std::span<const SoftFace> faces) {
    using Edge = std::pair<std::uint32_t, std::uint32_t>;
    std::vector<Edge> there;
    std::vector<Edge> back;
    for (const SoftFace& f : faces) {
        for (std::size_t i = 0; i < 3; ++i) {
            there.emplace_back(f[i], f[(i + 1) % 3]);
            back.emplace_back(f[(i + 1) % 3], f[i]);
        }
    }
    std::sort(there.begin(), there.end());
    std::sort(back.begin(), back.end());
    return !faces.empty() && there == back &&
           std::adjacent_find(there.begin(), there.end()) == there.end();
}

}  // namespace zoned::physics::soft
