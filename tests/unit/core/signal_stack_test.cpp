#include "shared/core/signal_stack.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <thread>

namespace zoned::core {
namespace {

stack_t stack_for_signals() {
    stack_t stack{};
    ::sigaltstack(nullptr, &stack);
    return stack;
}

/// Looks when the thread ends, after all that was made later in it is gone.
struct LastLook {
    stack_t* seen = nullptr;

    ~LastLook() {
        if (seen != nullptr) {
            *seen = stack_for_signals();
        }
    }
};

TEST(SignalStack, LivesAsLongAsItsThreadAndLeavesTheFormerOne) {
    stack_t before{};
    stack_t within{};
    stack_t after{};
    std::thread([&] {
        static thread_local LastLook last;
        last.seen = &after;
        before = stack_for_signals();
        add_signal_stack();
        within = stack_for_signals();
    }).join();
    EXPECT_NE(within.ss_sp, before.ss_sp);
    EXPECT_EQ(within.ss_flags, 0);
    EXPECT_GE(within.ss_size, 65536U);
    EXPECT_EQ(after.ss_sp, before.ss_sp);
    EXPECT_EQ(after.ss_flags, before.ss_flags);
}

}  // namespace
}  // namespace zoned::core
