// HostBlock: host memory aligned to a page, in which devices may work.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <new>
#include <utility>

namespace zoned::compute {

/// Zeroed. Sizes are rounded up to whole pages, which lets every driver map it without a copy.
class HostBlock {
  public:
    static constexpr std::size_t kPage = 4096;

    HostBlock() = default;

    explicit HostBlock(std::size_t bytes)
        : bytes_((bytes + kPage - 1) / kPage * kPage),
          data_(bytes_ > 0 ? std::aligned_alloc(kPage, bytes_) : nullptr) {
        if (bytes_ > 0 && data_ == nullptr) {
            throw std::bad_alloc();
        }
        if (bytes_ > 0) {
            std::memset(data_, 0, bytes_);
        }
    }

    HostBlock(HostBlock&& other) noexcept
        : bytes_(std::exchange(other.bytes_, 0)),
          data_(std::exchange(other.data_, nullptr)) {}

    HostBlock& operator=(HostBlock&& other) noexcept {
        std::swap(bytes_, other.bytes_);
        std::swap(data_, other.data_);
        return *this;
    }

    ~HostBlock() { std::free(data_); }

    [[nodiscard]] void* data() { return data_; }

    [[nodiscard]] const void* data() const { return data_; }

    template <class T>
    [[nodiscard]] T* as() {
        return static_cast<T*>(data_);
    }

    template <class T>
    [[nodiscard]] const T* as() const {
        return static_cast<const T*>(data_);
    }

    [[nodiscard]] std::size_t bytes() const { return bytes_; }

  private:
    std::size_t bytes_ = 0;
    void* data_ = nullptr;
};

}  // namespace zoned::compute
