// InlineVector: a short list that lies where its owner lies, without the heap.
#pragma once

#include "shared/core/assert.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <type_traits>

namespace zoned::core {

/// At most `Most` values of a plain type.
template <class T, std::size_t Most>
class InlineVector {
    static_assert(std::is_trivially_copyable_v<T> && Most <= UINT8_MAX);

  public:
    static constexpr std::size_t kMost = Most;

    InlineVector() = default;

    InlineVector(std::initializer_list<T> values) {
        for (const T& value : values) {
            push_back(value);
        }
    }

    /// It must not be full.
    void push_back(const T& value) {
        ZONED_ASSERT(size_ < Most, "a list of fixed room is full");
        values_[size_++] = value;
    }

    [[nodiscard]] std::size_t size() const { return size_; }

    [[nodiscard]] bool empty() const { return size_ == 0; }

    [[nodiscard]] const T* begin() const { return values_.data(); }

    [[nodiscard]] const T* end() const { return values_.data() + size_; }

    friend bool operator==(const InlineVector& a, const InlineVector& b) {
        return std::equal(a.begin(), a.end(), b.begin(), b.end());
    }

  private:
    std::array<T, Most> values_{};
    std::uint8_t size_ = 0;
};

}  // namespace zoned::core
