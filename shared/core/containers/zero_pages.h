// ZeroPages: an array that begins as zeros and takes memory only where it was touched.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

namespace zoned::core {

/// For large arrays of which most is never touched. The system gives pages of zeros at their first
/// use. A vector would write them all, and so may calloc() where it reuses memory.
template <class T>
class ZeroPages {
    static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

  public:
    ZeroPages() = default;

    /// All bytes of the elements are zero. Throws std::bad_alloc.
    explicit ZeroPages(std::size_t size) : size_(size) {
        if (size == 0) {
            return;
        }
        void* const memory = mmap(nullptr,
                                  size * sizeof(T),
                                  PROT_READ | PROT_WRITE,
                                  MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE,
                                  -1,
                                  0);
        if (memory == MAP_FAILED) {
            throw std::bad_alloc();
        }
        memory_ = static_cast<T*>(memory);
    }

    ZeroPages(ZeroPages&& other) noexcept
        : memory_(std::exchange(other.memory_, nullptr)),
          size_(std::exchange(other.size_, 0)) {}

    ZeroPages& operator=(ZeroPages&& other) noexcept {
        std::swap(memory_, other.memory_);
        std::swap(size_, other.size_);
        return *this;
    }

    ZeroPages(const ZeroPages&) = delete;
    ZeroPages& operator=(const ZeroPages&) = delete;

    ~ZeroPages() {
        if (memory_ != nullptr) {
            munmap(memory_, size_ * sizeof(T));
        }
    }

    [[nodiscard]] T& operator[](std::size_t i) { return memory_[i]; }

    [[nodiscard]] const T& operator[](std::size_t i) const { return memory_[i]; }

    [[nodiscard]] std::size_t size() const { return size_; }

    [[nodiscard]] std::span<T> all() { return {memory_, size_}; }

    [[nodiscard]] std::span<const T> all() const { return {memory_, size_}; }

  private:
    T* memory_ = nullptr;
    std::size_t size_ = 0;
};

}  // namespace zoned::core
