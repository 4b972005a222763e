// FieldWriter, FieldReader: write numbers one after the other, and read them again.
// Reached by no program yet: snapshots of zones will use it.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace zoned::ai {

/// A number as an unsigned one of the same size.
template <class Number>
auto bits_of(Number number) {
    if constexpr (std::is_same_v<Number, float>) {
        return std::bit_cast<std::uint32_t>(number);
    } else if constexpr (std::is_same_v<Number, double>) {
        return std::bit_cast<std::uint64_t>(number);
    } else if constexpr (std::is_same_v<Number, bool>) {
        return static_cast<std::uint8_t>(number);
    } else if constexpr (std::is_enum_v<Number>) {
        return static_cast<std::underlying_type_t<Number>>(number);
    } else {
        return static_cast<std::make_unsigned_t<Number>>(number);
    }
}

/// Appends numbers: little endian, floats by their bits.
class FieldWriter {
  public:
    explicit FieldWriter(std::vector<std::uint8_t>& out) : out_(out) {}

    template <class Number>
    void operator()(const Number& number) {
        const auto bits = bits_of(number);
        for (std::size_t b = 0; b < sizeof(bits); ++b) {
            out_.push_back(static_cast<std::uint8_t>(bits >> (8U * b) & 0xFFU));
        }
    }

  private:
    std::vector<std::uint8_t>& out_;
};

/// Reads the output of FieldWriter. Beyond its end, all numbers are 0.
class FieldReader {
  public:
    explicit FieldReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    template <class Number>
    void operator()(Number& number) {
        using Bits = decltype(bits_of(number));
        Bits bits = 0;
        if (bytes_.size() - at_ < sizeof(Bits)) {
            short_ = true;
            number = Number{};
            return;
        }
        for (std::size_t b = 0; b < sizeof(Bits); ++b) {
            bits = static_cast<Bits>(bits | static_cast<Bits>(bytes_[at_++]) << (8U * b));
        }
        if constexpr (std::is_floating_point_v<Number>) {
            number = std::bit_cast<Number>(bits);
            finite_ = finite_ && std::isfinite(number);
        } else if constexpr (std::is_same_v<Number, bool>) {
            known_ = known_ && bits <= 1;
            number = bits != 0;
        } else {
            number = static_cast<Number>(bits);
        }
    }

    [[nodiscard]] bool cut_short() const { return short_; }

    /// Whether all floats so far were finite.
    [[nodiscard]] bool finite() const { return finite_; }

    /// Whether all booleans so far were 0 or 1.
    [[nodiscard]] bool known() const { return known_; }

    [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

  private:
    std::span<const std::uint8_t> bytes_;
    std::size_t at_ = 0;
    bool short_ = false;
    bool finite_ = true;
    bool known_ = true;
};

}  // namespace zoned::ai
