// Range coder: writes symbols of known probability as bytes, close to their entropy.
#pragma once

#include "shared/core/assert.h"
#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

namespace zoned::wire::entropy {

/// Probabilities are shares of 2^kProbabilityBits.
inline constexpr int kProbabilityBits = 15;
inline constexpr std::uint32_t kProbabilityOne = 1u << kProbabilityBits;
/// Most bits that encode_raw() takes at a time.
inline constexpr int kMaxRawBits = 16;

/// Below this the interval takes another byte: every symbol then still has 2^9 steps at least.
inline constexpr std::uint32_t kLeastRange = 1u << 24;

/// Information of an interval narrowed to `range` after a number of byte shifts, bits.
inline double used_bits(std::size_t shifts, std::uint32_t range) {
    return 8.0 * static_cast<double>(shifts) + 32.0 -
           std::numbers::log2e * elementary::log(static_cast<double>(range));
}

/// Range encoder with carry propagation into bytes already written (G. N. N. Martin, "Range
/// encoding: an algorithm for removing redundancy from a digitised message", 1979; the form with a
/// byte-wise normalised 32-bit interval is M. Schindler's, 1998). Bits with equally likely values
/// take no arithmetic: they fill bytes of their own, which end the code in reverse order.
class RangeEncoder {
  public:
    /// Appends to `out`, which must outlive the encoder and not be touched before finish().
    explicit RangeEncoder(std::vector<std::uint8_t>& out) : RangeEncoder(out, own_raw_bytes_) {}

    /// `raw_bytes`: working memory that outlives the encoder, so that it need not be allocated.
    RangeEncoder(std::vector<std::uint8_t>& out, std::vector<std::uint8_t>& raw_bytes)
        : out_(out),
          begin_(out.size()),
          raw_bytes_(raw_bytes) {
        raw_bytes_.clear();
    }

    RangeEncoder(const RangeEncoder&) = delete;
    RangeEncoder& operator=(const RangeEncoder&) = delete;

    /// A symbol that owns [start, start + size) of kProbabilityOne; size > 0.
    void encode(std::uint32_t start, std::uint32_t size) {
        const std::uint32_t step = range_ >> kProbabilityBits;
        const std::uint32_t before = low_;
        low_ += step * start;
        range_ = step * size;
        if (low_ < before) {
            carry();
        }
        while (range_ < kLeastRange) {
            out_.push_back(static_cast<std::uint8_t>(low_ >> 24));
            low_ <<= 8;
            range_ <<= 8;
        }
    }

    /// The low `bits` (0..kMaxRawBits) bits of `value`, all values alike.
    void encode_raw(std::uint32_t value, int bits) {
        raw_ |= static_cast<std::uint64_t>(value & ((1u << bits) - 1)) << raw_bits_;
        raw_bits_ += bits;
        while (raw_bits_ >= 8) {
            raw_bytes_.push_back(static_cast<std::uint8_t>(raw_));
            raw_ >>= 8;
            raw_bits_ -= 8;
        }
    }

    /// Information written so far, bits; before finish(). Encoder and decoder agree on it at each
    /// place.
    [[nodiscard]] double bits() const {
        return used_bits(out_.size() - begin_, range_) +
               static_cast<double>(8 * raw_bytes_.size() + static_cast<std::size_t>(raw_bits_));
    }

    /// Ends the code with as few bytes (at most four) as distinguish it from all others, whatever
    /// follows them.
    void finish() {
        for (int bytes = 0; bytes <= 4; ++bytes) {
            const std::uint32_t below = bytes == 4 ? 0 : 0xFFFFFFFFu >> (8 * bytes);
            const std::uint64_t code = (std::uint64_t{low_} + below) & ~std::uint64_t{below};
            if (code + below < std::uint64_t{low_} + range_) {
                if (code > 0xFFFFFFFFu) {
                    carry();
                }
                for (int i = 0; i < bytes; ++i) {
                    out_.push_back(static_cast<std::uint8_t>(code >> (24 - 8 * i)));
                }
                break;
            }
        }
        if (raw_bits_ > 0) {
            raw_bytes_.push_back(static_cast<std::uint8_t>(raw_));
        }
        out_.insert(out_.end(), raw_bytes_.rbegin(), raw_bytes_.rend());
    }

  private:
    /// The code never reaches 1, so a carry ends before the first byte.
    void carry() {
        for (std::size_t i = out_.size(); i > begin_ && ++out_[i - 1] == 0;) {
            --i;
        }
    }

    std::vector<std::uint8_t>& out_;
    std::size_t begin_;
    std::uint32_t low_ = 0;
    std::uint32_t range_ = 0xFFFFFFFFu;
    std::uint64_t raw_ = 0;
    int raw_bits_ = 0;
    std::vector<std::uint8_t>& raw_bytes_;
    std::vector<std::uint8_t> own_raw_bytes_;
};

/// Reads what RangeEncoder wrote. Bytes are hostile: decoding always goes on with some symbols.
/// complete() tells whether an encoder can have written them.
class RangeDecoder {
  public:
    explicit RangeDecoder(std::span<const std::uint8_t> bytes)
        : bytes_(bytes),
          raw_end_(bytes.size()) {
        for (std::size_t i = 0; i < kAhead; ++i) {
            code_ = code_ << 8 | next();
        }
    }

    /// Position of the next symbol in [0, kProbabilityOne); must be followed by take() of the
    /// symbol that owns the position.
    [[nodiscard]] std::uint32_t peek() {
        step_ = range_ >> kProbabilityBits;
        return std::min(code_ / step_, kProbabilityOne - 1);
    }

    void take(std::uint32_t start, std::uint32_t size) {
        code_ -= step_ * start;
        range_ = step_ * size;
        while (range_ < kLeastRange) {
            code_ = code_ << 8 | next();
            range_ <<= 8;
        }
    }

    std::uint32_t decode_raw(int bits) {
        while (raw_bits_ < bits) {
            const std::uint64_t byte = raw_end_ > 0 ? bytes_[--raw_end_] : ++missing_ * 0;
            raw_ |= byte << raw_bits_;
            raw_bits_ += 8;
        }
        const auto value = static_cast<std::uint32_t>(raw_) & ((1u << bits) - 1);
        raw_ >>= bits;
        raw_bits_ -= bits;
        return value;
    }

    /// As RangeEncoder::bits().
    [[nodiscard]] double bits() const {
        return used_bits(position_ - kAhead, range_) +
               static_cast<double>(8 * (bytes_.size() - raw_end_)) - static_cast<double>(raw_bits_);
    }

    /// Whether an encoder can have written exactly these bytes for the symbols read: none missing,
    /// none left over, the last bits zero.
    [[nodiscard]] bool complete() const {
        const std::size_t shifted = position_ - kAhead;
        return missing_ == 0 && raw_ == 0 && shifted <= raw_end_ && raw_end_ - shifted <= kAhead;
    }

  private:
    /// Bytes that the decoder looks ahead, which are as many as finish() writes at most.
    static constexpr std::size_t kAhead = 4;

    /// Behind the bytes come zeros: finish() may have needed fewer than are looked at.
    std::uint32_t next() {
        const std::size_t at = position_++;
        return at < bytes_.size() ? bytes_[at] : 0;
    }

    std::span<const std::uint8_t> bytes_;
    std::size_t position_ = 0;
    std::size_t raw_end_;  // raw bytes behind this place are read
    std::size_t missing_ = 0;
    std::uint64_t raw_ = 0;
    int raw_bits_ = 0;
    std::uint32_t code_ = 0;
    std::uint32_t range_ = 0xFFFFFFFFu;
    std::uint32_t step_ = 1;
};

}  // namespace zoned::wire::entropy
