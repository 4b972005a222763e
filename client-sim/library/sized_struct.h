// SizedStruct: copies between structs of the C interface that grow at their end.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace zoned::library {

/// The caller's struct as far as it reaches; what it does not know is 0. False without one.
template <class Struct>
[[nodiscard]] bool take(const Struct* from, Struct& out) {
    out = {};
    if (from == nullptr || from->size < sizeof(from->size)) {
        return false;
    }
    std::memcpy(&out, from, std::min<std::size_t>(from->size, sizeof(Struct)));
    return true;
}

/// Fills as much of the caller's struct as both sides know, and keeps its size. False without one.
template <class Struct>
bool give(Struct* out, const Struct& value) {
    if (out == nullptr || out->size < sizeof(out->size)) {
        return false;
    }
    const std::uint32_t size = out->size;
    std::memcpy(out, &value, std::min<std::size_t>(size, sizeof(Struct)));
    out->size = size;
    return true;
}

/// The caller's array, whose first element says how far apart its elements are.
template <class Struct>
class SizedArray {
  public:
    SizedArray(Struct* out, std::size_t capacity)
        : out_(reinterpret_cast<unsigned char*>(out)),
          size_(out != nullptr && capacity > 0 ? out->size : 0),
          capacity_(size_ >= sizeof(size_) ? capacity : 0) {}

    /// Counts one more, and fills it where there is room.
    void add(const Struct& value) {
        if (count_ < capacity_) {
            unsigned char* const at = out_ + count_ * size_;
            std::memcpy(at, &value, std::min<std::size_t>(size_, sizeof(Struct)));
            std::memcpy(at, &size_, sizeof(size_));
        }
        ++count_;
    }

    [[nodiscard]] std::size_t count() const { return count_; }

  private:
    unsigned char* out_;
    std::uint32_t size_;
    std::size_t capacity_;
    std::size_t count_ = 0;
};

}  // namespace zoned::library
