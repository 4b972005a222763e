// ForeignHandle: something of the system or of a C library that is given back at the end.
#pragma once

namespace zoned::core {

class ForeignHandle;

/// The handles that were made on this thread while the list was the current one. Where memory runs
/// out in a build without exceptions, objects are left behind without their destructors: their
/// handles are closed by the list.
class ForeignHandles {
  public:
    ForeignHandles() = default;
    ForeignHandles(const ForeignHandles&) = delete;
    ForeignHandles& operator=(const ForeignHandles&) = delete;

    /// Closes all and forgets them. Their owners must not be touched again.
    void close_all() noexcept;

    /// From now on on this thread; nullptr: nobody lists them. Returns the one before.
    static ForeignHandles* use(ForeignHandles* list) noexcept;

  private:
    friend class ForeignHandle;
    ForeignHandle* first_ = nullptr;
};

class ForeignHandle {
  public:
    using Close = void (*)(void* handle);

    /// `handle` may be nullptr: nothing is closed.
    ForeignHandle(void* handle, Close close) noexcept;
    ~ForeignHandle();
    ForeignHandle(const ForeignHandle&) = delete;
    ForeignHandle& operator=(const ForeignHandle&) = delete;

    [[nodiscard]] void* get() const { return handle_; }

  private:
    friend class ForeignHandles;
    void* handle_;
    Close close_;
    ForeignHandle** to_this_ = nullptr;  // the link that leads here; nullptr: not listed
    ForeignHandle* next_ = nullptr;
};

/// A handle of a type that a function of a C library frees.
template <class T, void (*kFree)(T*)>
class Foreign {
  public:
    explicit Foreign(T* handle) noexcept
        : handle_(handle, [](void* closed) { kFree(static_cast<T*>(closed)); }) {}

    [[nodiscard]] T* get() const { return static_cast<T*>(handle_.get()); }

  private:
    ForeignHandle handle_;
};

}  // namespace zoned::core
