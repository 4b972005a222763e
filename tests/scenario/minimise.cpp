#include "tests/scenario/minimise.h"

#include <algorithm>

namespace zoned::scenario {

std::vector<std::size_t> minimise(std::size_t count,
                                  const std::function<bool(const std::vector<std::size_t>&)>& fails,
                                  int& budget) {
    std::vector<std::size_t> kept(count);
    for (std::size_t i = 0; i < count; ++i) {
        kept[i] = i;
    }
    const auto test = [&](const std::vector<std::size_t>& part) {
        return budget-- > 0 && fails(part);
    };
    std::size_t pieces = 2;
    while (!kept.empty() && budget > 0) {
        pieces = std::min(pieces, kept.size());
        bool less = false;
        for (const bool complement : {false, true}) {
            for (std::size_t p = 0; p < pieces && !less; ++p) {
                const std::size_t from = p * kept.size() / pieces;
                const std::size_t to = (p + 1) * kept.size() / pieces;
                std::vector<std::size_t> part;
                for (std::size_t i = 0; i < kept.size(); ++i) {
                    if ((i >= from && i < to) != complement) {
                        part.push_back(kept[i]);
                    }
                }
                if (part.size() < kept.size() && test(part)) {
                    kept = std::move(part);
                    pieces = complement ? std::max<std::size_t>(pieces - 1, 2) : 2;
                    less = true;
                }
            }
        }
        if (!less) {
            if (pieces >= kept.size()) {
                break;
            }
            pieces = std::min(2 * pieces, kept.size());
        }
    }
    return kept;
}

}  // namespace zoned::scenario
