// Bit streams: bits of a record, least significant first, packed into little-endian bytes.
#pragma once

#include "shared/core/assert.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace zoned::wire {

static_assert(std::endian::native == std::endian::little, "bit streams load little-endian words");

/// The low `bits` bits set; bits 0..32.
constexpr std::uint32_t low_mask(int bits) {
    return static_cast<std::uint32_t>((std::uint64_t{1} << bits) - 1);
}

/// The signed number of `bits` bits (1..32) in two's complement.
constexpr std::int32_t sign_extend(std::uint32_t value, int bits) {
    const std::uint32_t sign = 1u << (bits - 1);
    return static_cast<std::int32_t>((value ^ sign) - sign);
}

/// Collects up to kCapacityBytes bytes of bits on the stack and appends them to a vector at once:
/// records are short, and one append is much cheaper than a push per byte.
class BitWriter {
  public:
    static constexpr std::size_t kCapacityBytes = 640;

    /// Appends the low `bits` bits (0..32) of `value`.
    void write(std::uint32_t value, int bits) {
        accumulator_ |= static_cast<std::uint64_t>(value & low_mask(bits)) << filled_;
        filled_ += bits;
        if (filled_ >= 32) {
            ZONED_ASSERT(size_ + 4 <= kCapacityBytes, "a record outgrew its buffer");
            std::memcpy(buffer_.data() + size_, &accumulator_, 4);
            size_ += 4;
            accumulator_ >>= 32;
            filled_ -= 32;
        }
    }

    /// Pads with zero bits to a whole byte and appends everything to `out`; the writer is empty
    /// then.
    void finish(std::vector<std::uint8_t>& out) {
        ZONED_ASSERT(size_ + 4 <= kCapacityBytes, "a record outgrew its buffer");
        std::memcpy(buffer_.data() + size_, &accumulator_, 4);
        size_ += static_cast<std::size_t>(filled_ + 7) / 8;
        out.insert(out.end(), buffer_.data(), buffer_.data() + size_);
        size_ = 0;
        accumulator_ = 0;
        filled_ = 0;
    }

  private:
    std::array<std::uint8_t, kCapacityBytes> buffer_;  // Only the first size_ bytes hold anything.
    std::uint64_t accumulator_ = 0;
    int filled_ = 0;
    std::size_t size_ = 0;
};

/// Reads bits and never touches a byte outside its span: reading past the end gives zeros and sets
/// a flag that stays.
class BitReader {
  public:
    BitReader() = default;

    explicit BitReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    /// The next `bits` bits (0..32) as an unsigned number; 0 once the reader has failed.
    std::uint32_t read(int bits) {
        const std::size_t end = position_ + static_cast<std::size_t>(bits);
        if (end > bytes_.size() * 8) {
            failed_ = true;
            position_ = bytes_.size() * 8;
            return 0;
        }
        const std::uint64_t word = load(position_ / 8) >> (position_ % 8);
        position_ = end;
        return static_cast<std::uint32_t>(word) & low_mask(bits);
    }

    /// Moves to the next whole byte; the bits passed over must be zero, so that equal values have
    /// equal bytes.
    void align() {
        const int padding = static_cast<int>((8 - position_ % 8) % 8);
        if (read(padding) != 0) {
            failed_ = true;
        }
    }

    [[nodiscard]] bool failed() const { return failed_; }

    /// Offset of the next byte; meaningful after align().
    [[nodiscard]] std::size_t byte_offset() const { return (position_ + 7) / 8; }

    /// Offset of the next bit.
    [[nodiscard]] std::size_t bit_offset() const { return position_; }

    [[nodiscard]] bool at_end() const { return position_ == bytes_.size() * 8; }

  private:
    /// Eight bytes from `offset`, zeros beyond the end.
    [[nodiscard]] std::uint64_t load(std::size_t offset) const {
        std::uint64_t word = 0;
        const std::size_t left = bytes_.size() - offset;
        if (left >= 8) {
            std::memcpy(&word, bytes_.data() + offset, 8);
        } else if (left != 0) {
            std::memcpy(&word, bytes_.data() + offset, left);
        }
        return word;
    }

    std::span<const std::uint8_t> bytes_;
    std::size_t position_ = 0;  // in bits
    bool failed_ = false;
};

/// Widths of an unsigned number, chosen by a 2-bit selector.
using VarintWidths = std::array<int, 4>;

/// Writes a 2-bit selector and the number in the narrowest of the ascending `widths` that holds it.
inline void write_varint(BitWriter& writer, std::uint32_t value, const VarintWidths& widths) {
    std::uint32_t selector = 0;
    while (selector < 3 && value > low_mask(widths[selector])) {
        ++selector;
    }
    writer.write(selector, 2);
    writer.write(value, widths[selector]);
}

/// Reads what write_varint wrote. `canonical` becomes false when a narrower width would have done.
inline std::uint32_t read_varint(BitReader& reader, const VarintWidths& widths, bool& canonical) {
    const std::uint32_t selector = reader.read(2);
    const std::uint32_t value = reader.read(widths[selector]);
    if (selector > 0 && value <= low_mask(widths[selector - 1])) {
        canonical = false;
    }
    return value;
}

/// Appends an unsigned number in bytes of 7 bits, low first, top bit set on all but the last
/// (LEB128; DWARF 5, section 7.6).
inline void append_leb128(std::uint32_t value, std::vector<std::uint8_t>& out) {
    while (value >= 0x80) {
        out.push_back(static_cast<std::uint8_t>(value | 0x80));
        value >>= 7;
    }
    out.push_back(static_cast<std::uint8_t>(value));
}

/// Reads a LEB128 number of at most 32 bits at `offset` and moves the offset behind it. False when
/// it is cut off, too large or longer than needed.
inline bool read_leb128(std::span<const std::uint8_t> bytes,
                        std::size_t& offset,
                        std::uint32_t& value) {
    std::uint64_t result = 0;
    for (int shift = 0; shift < 35; shift += 7) {
        if (offset >= bytes.size()) {
            return false;
        }
        const std::uint8_t byte = bytes[offset++];
        result |= static_cast<std::uint64_t>(byte & 0x7F) << shift;
        if ((byte & 0x80) == 0) {
            value = static_cast<std::uint32_t>(result);
            return result <= 0xFFFFFFFFu && (byte != 0 || shift == 0);
        }
    }
    return false;
}

}  // namespace zoned::wire
