// Slices: work written in one piece that is done a part at a time.
#pragma once

#include <coroutine>
#include <cstdint>
#include <exception>
#include <utility>

namespace zoned::ai::navigation {

/// Units of work that a part has taken.
struct Spent {
    std::uint64_t units;
};

/// What a coroutine that says `co_await Spent{n}` now and then returns: it stops there once the
/// units that it was given are used up, and goes on at the next call. Units are counted, so that it
/// stops at the same places everywhere.
class Slices {
  public:
    class promise_type {
      public:
        Slices get_return_object() { return Slices(Handle::from_promise(*this)); }

        static std::suspend_always initial_suspend() noexcept { return {}; }

        static std::suspend_always final_suspend() noexcept { return {}; }

        void return_void() {}

        [[noreturn]] static void unhandled_exception() { std::terminate(); }

        struct Stop {
            bool go_on;

            [[nodiscard]] bool await_ready() const noexcept { return go_on; }

            void await_suspend(std::coroutine_handle<> /*self*/) const noexcept {}

            void await_resume() const noexcept {}
        };

        Stop await_transform(Spent spent) {
            const bool go_on = spent.units < left_;
            left_ = go_on ? left_ - spent.units : 0;
            return {go_on};
        }

      private:
        friend class Slices;
        std::uint64_t left_ = 0;
    };

    Slices() = default;

    Slices(Slices&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}

    Slices& operator=(Slices&& other) noexcept {
        std::swap(handle_, other.handle_);
        return *this;
    }

    Slices(const Slices&) = delete;
    Slices& operator=(const Slices&) = delete;

    ~Slices() {
        if (handle_) {
            handle_.destroy();
        }
    }

    /// Goes on for about so many units. True once all is done; it is from the start where there is
    /// nothing to do.
    bool advance(std::uint64_t units) {
        if (!handle_ || handle_.done()) {
            return true;
        }
        handle_.promise().left_ = units;
        handle_.resume();
        return handle_.done();
    }

  private:
    using Handle = std::coroutine_handle<promise_type>;

    explicit Slices(Handle handle) : handle_(handle) {}

    Handle handle_;
};

}  // namespace zoned::ai::navigation
