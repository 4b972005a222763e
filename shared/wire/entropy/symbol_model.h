// Symbol models: adaptive probabilities of yes/no decisions and of alphabets of 16.
#pragma once

#include "shared/wire/entropy/range_coder.h"

#include <array>
#include <cstdint>

namespace zoned::wire::entropy {

/// Probability of a 1, the mean of a quick and a slow estimate: the quick one follows changes, the
/// slow one is exact where nothing changes.
class BitModel {
  public:
    /// `one` is the first probability of a 1, in 2^16.
    explicit BitModel(std::uint16_t one = 1u << 15) : quick_(one), slow_(one) {}

    void encode(RangeEncoder& coder, bool bit) const {
        const std::uint32_t one = share_of_one();
        if (bit) {
            coder.encode(0, one);
        } else {
            coder.encode(one, kProbabilityOne - one);
        }
    }

    [[nodiscard]] bool decode(RangeDecoder& coder) const {
        const std::uint32_t one = share_of_one();
        const bool bit = coder.peek() < one;
        if (bit) {
            coder.take(0, one);
        } else {
            coder.take(one, kProbabilityOne - one);
        }
        return bit;
    }

    void learning(bool bit) {
        if (bit) {
            quick_ = static_cast<std::uint16_t>(quick_ + ((0xFFFFu - quick_) >> kQuick));
            slow_ = static_cast<std::uint16_t>(slow_ + ((0xFFFFu - slow_) >> kSlow));
        } else {
            quick_ = static_cast<std::uint16_t>(quick_ - (quick_ >> kQuick));
            slow_ = static_cast<std::uint16_t>(slow_ - (slow_ >> kSlow));
        }
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(quick_, slow_);
    }

  private:
    static constexpr int kQuick = 4;
    static constexpr int kSlow = 7;
    // Nothing is ever sure: a decision costs 10 bits at most.
    static constexpr std::uint32_t kLeast = kProbabilityOne >> 10;

    [[nodiscard]] std::uint32_t share_of_one() const {
        const std::uint32_t mean = (std::uint32_t{quick_} + slow_) >> (17 - kProbabilityBits);
        return mean < kLeast ? kLeast
                             : (mean > kProbabilityOne - kLeast ? kProbabilityOne - kLeast : mean);
    }

    std::uint16_t quick_;
    std::uint16_t slow_;
};

/// Probabilities of 16 symbols, as the start of each symbol's range. Learning moves every start
/// towards its value if the last symbol were (nearly) sure; 16 starts fill one or two vector
/// registers. (F. Giesen, "Models for adaptive arithmetic coding", 2015.)
class SymbolModel {
  public:
    static constexpr int kSymbols = 16;

    /// All alike.
    SymbolModel() {
        std::array<std::uint32_t, kSymbols> weights;
        weights.fill(1);
        set(weights);
    }

    /// Probabilities in proportion to `weights`, none of which may be 0; their sum < 2^16.
    void set(const std::array<std::uint32_t, kSymbols>& weights);

    void encode(RangeEncoder& coder, int symbol) const {
        const std::uint32_t start = begin(symbol);
        coder.encode(start, end(symbol) - start);
    }

    [[nodiscard]] int decode(RangeDecoder& coder) const {
        const auto place = static_cast<std::int16_t>(coder.peek() >> 1);
        std::int16_t behind = -1;  // place 0 is never behind
        for (std::size_t i = 0; i < kSymbols; ++i) {
            behind = static_cast<std::int16_t>(behind + (place_[i] <= place ? 1 : 0));
        }
        const int symbol = behind;
        const std::uint32_t start = begin(symbol);
        coder.take(start, end(symbol) - start);
        return symbol;
    }

    void learning(int symbol) {
        const Cumulative& sure = kSure[static_cast<std::size_t>(symbol)];
        for (std::size_t i = 0; i < kSymbols; ++i) {
            const auto away = static_cast<std::int16_t>(sure[i] - place_[i]);
            place_[i] =
                static_cast<std::int16_t>(place_[i] + static_cast<std::int16_t>(away >> kRate));
        }
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(place_);
        if constexpr (Archive::kReads) {
            bool sound = place_[0] == 0 && place_.back() < kWhole;
            for (std::size_t i = 1; i < kSymbols; ++i) {
                sound = sound && place_[i - 1] < place_[i];
            }
            if (!sound) {
                archive.fail("a symbol has no share of the probability");
            }
        }
    }

  private:
    static constexpr int kRate = 7;
    // Starts have 14 bits: differences of two then fit into 16.
    static constexpr int kWhole = 1 << (kProbabilityBits - 1);
    // An estimate never falls below this: a rare symbol costs 11 bits at most.
    static constexpr int kLeast = 8;

    using Cumulative = std::array<std::int16_t, kSymbols>;

    /// Starts of symbols when one of them is as sure as possible.
    static constexpr std::array<Cumulative, kSymbols> kSure = [] {
        std::array<Cumulative, kSymbols> all{};
        for (int symbol = 0; symbol < kSymbols; ++symbol) {
            for (int i = 0; i < kSymbols; ++i) {
                const int place = i <= symbol ? i * kLeast : kWhole - (kSymbols - i) * kLeast;
                all[static_cast<std::size_t>(symbol)][static_cast<std::size_t>(i)] =
                    static_cast<std::int16_t>(place);
            }
        }
        return all;
    }();

    [[nodiscard]] std::uint32_t begin(int symbol) const {
        return 2 * static_cast<std::uint32_t>(place_[static_cast<std::size_t>(symbol)]);
    }

    [[nodiscard]] std::uint32_t end(int symbol) const {
        return symbol + 1 < kSymbols ? begin(symbol + 1) : kProbabilityOne;
    }

    Cumulative place_;  // place 0 is 0
};

}  // namespace zoned::wire::entropy
