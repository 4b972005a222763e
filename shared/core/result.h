// Result: a value, or the reason for its absence, for bytes and settings that come from outside.
#pragma once

#include "shared/core/assert.h"

#include <optional>
#include <string>
#include <utility>

namespace zoned::core {

/// Either a value of type T or an error of type E (a short text unless said otherwise).
template <class T, class E = std::string>
class [[nodiscard]] Result {
  public:
    // Implicit on purpose: `return value;` and `return Result::failure(reason);` both read well.
    // NOLINTNEXTLINE(google-explicit-constructor)
    Result(T value) : value_(std::move(value)) {}

    static Result failure(E error) {
        Result r;
        r.error_ = std::move(error);
        return r;
    }

    [[nodiscard]] bool ok() const { return value_.has_value(); }

    explicit operator bool() const { return ok(); }

    [[nodiscard]] const T& value() const& {
        ZONED_ASSERT(ok(), "value() of a failed Result");
        return *value_;
    }

    [[nodiscard]] T& value() & {
        ZONED_ASSERT(ok(), "value() of a failed Result");
        return *value_;
    }

    [[nodiscard]] T&& value() && {
        ZONED_ASSERT(ok(), "value() of a failed Result");
        return std::move(*value_);
    }

    const T& operator*() const { return value(); }

    T& operator*() { return value(); }

    const T* operator->() const { return &value(); }

    T* operator->() { return &value(); }

    [[nodiscard]] const E& error() const {
        ZONED_ASSERT(!ok(), "error() of a Result that holds a value");
        return error_;
    }

  private:
    Result() = default;

    std::optional<T> value_;
    E error_{};
};

}  // namespace zoned::core
