// ResumableTask: a coroutine whose work is done a part at a time.
#pragma once

#include <coroutine>
#include <cstdint>
#include <exception>
#include <utility>

namespace zoned::ai::pathfinding {

/// Spent: the units of work that a part has taken.
struct Spent {
    std::uint64_t units;
};

/// The cost of first writing on so many bytes of memory, or of freeing them, in units of about 2
/// ns: half a microsecond for a page.
constexpr std::uint64_t memory_units(std::size_t bytes) {
    return bytes / 8;
}

/// The return type of a coroutine that now and then calls `co_await Spent{n}`. It stops there once
/// the units that it was given are used up, and goes on at the next call. Units are counted, so
/// that it stops at the same places everywhere. The next calls pay for units that a part took in
/// excess.
///
/// `co_await` is true once the work is cancelled. Then the coroutine frees what it has made, in
/// parts too, touches nothing else, and returns.
class ResumableTask {
  public:
    class promise_type {
      public:
        ResumableTask get_return_object() { return ResumableTask(Handle::from_promise(*this)); }

        static std::suspend_always initial_suspend() noexcept { return {}; }

        static std::suspend_always final_suspend() noexcept { return {}; }

        void return_void() {}

        [[noreturn]] static void unhandled_exception() { std::terminate(); }

        struct Pause {
            const promise_type& of;
            bool go_on;

            [[nodiscard]] bool await_ready() const noexcept { return go_on; }

            void await_suspend(std::coroutine_handle<> /*self*/) const noexcept {}

            /// True if the work is cancelled.
            bool await_resume() const noexcept { return of.cancelled_; }
        };

        Pause await_transform(Spent spent) {
            spent_ += spent.units;
            return {*this, spent_ < given_};
        }

      private:
        friend class ResumableTask;
        std::uint64_t given_ = 0;
        std::uint64_t spent_ = 0;
        bool cancelled_ = false;
    };

    ResumableTask() = default;

    ResumableTask(ResumableTask&& other) noexcept
        : handle_(std::exchange(other.handle_, nullptr)),
          owed_(std::exchange(other.owed_, 0)) {}

    ResumableTask& operator=(ResumableTask&& other) noexcept {
        std::swap(handle_, other.handle_);
        std::swap(owed_, other.owed_);
        return *this;
    }

    ResumableTask(const ResumableTask&) = delete;
    ResumableTask& operator=(const ResumableTask&) = delete;

    ~ResumableTask() {
        if (handle_) {
            handle_.destroy();
        }
    }

    /// Goes on for about so many units. True once all is done; true from the start where there is
    /// nothing to do.
    bool advance(std::uint64_t units) {
        taken_ = 0;
        if (!handle_ || handle_.done()) {
            return true;
        }
        if (owed_ >= units) {
            owed_ -= units;
            return false;
        }
        handle_.promise().given_ = units - owed_;
        handle_.promise().spent_ = 0;
        owed_ = 0;
        handle_.resume();
        taken_ = handle_.promise().spent_;
        owed_ = taken_ > handle_.promise().given_ ? taken_ - handle_.promise().given_ : 0;
        return handle_.done();
    }

    /// Units that the last advance() has taken; they exceed the units given where a part was large.
    [[nodiscard]] std::uint64_t taken() const { return taken_; }

    /// Makes the next calls only clear up.
    void cancel() {
        if (handle_) {
            handle_.promise().cancelled_ = true;
        }
    }

  private:
    using Handle = std::coroutine_handle<promise_type>;

    explicit ResumableTask(Handle handle) : handle_(handle) {}

    Handle handle_;
    std::uint64_t owed_ = 0;
    std::uint64_t taken_ = 0;
};

}  // namespace zoned::ai::pathfinding
