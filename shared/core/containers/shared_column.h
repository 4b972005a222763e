// SharedColumn: an array that never changes, which copies share.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace zoned::core {

/// Reading costs what it costs in a vector.
template <class T>
class SharedColumn {
  public:
    SharedColumn() = default;

    explicit SharedColumn(std::vector<T> items)
        : items_(std::make_shared<const std::vector<T>>(std::move(items))),
          span_(*items_) {}

    [[nodiscard]] const T& operator[](std::size_t i) const { return span_[i]; }

    [[nodiscard]] std::size_t size() const { return span_.size(); }

    [[nodiscard]] bool empty() const { return span_.empty(); }

    [[nodiscard]] const T* data() const { return span_.data(); }

    [[nodiscard]] auto begin() const { return span_.begin(); }

    [[nodiscard]] auto end() const { return span_.end(); }

    /// To be changed and put into another column.
    [[nodiscard]] std::vector<T> copy() const { return {span_.begin(), span_.end()}; }

    operator std::span<const T>() const { return span_; }  // NOLINT(google-explicit-constructor)

  private:
    std::shared_ptr<const std::vector<T>> items_;
    std::span<const T> span_;
};

}  // namespace zoned::core
