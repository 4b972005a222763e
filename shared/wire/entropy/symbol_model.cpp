#include "shared/wire/entropy/symbol_model.h"

namespace zoned::wire::entropy {

void SymbolModel::set(const std::array<std::uint32_t, kSymbols>& weights) {
    std::uint32_t sum = 0;
    for (const std::uint32_t weight : weights) {
        ZONED_ASSERT(weight > 0, "every symbol may come");
        sum += weight;
    }
    // Each symbol has its least share, the rest is shared out by weight.
    const std::uint32_t rest = kWhole - kSymbols * kLeast;
    std::uint32_t before = 0;
    for (std::size_t i = 0; i < kSymbols; ++i) {
        place_[i] = static_cast<std::int16_t>(i * kLeast + rest * before / sum);
        before += weights[i];
    }
}

}  // namespace zoned::wire::entropy
