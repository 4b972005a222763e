#include "shared/core/signal_stack.h"

#include <signal.h>

#include <array>
#include <memory>

namespace zoned::core {

namespace {

constexpr std::size_t kSignalStackBytes = 65536;

}  // namespace

void add_signal_stack() {
    thread_local std::unique_ptr<std::array<char, kSignalStackBytes>> memory;
    if (memory) {
        return;
    }
    memory = std::make_unique<std::array<char, kSignalStackBytes>>();
    stack_t stack{};
    stack.ss_sp = memory->data();
    stack.ss_size = memory->size();
    ::sigaltstack(&stack, nullptr);
}

}  // namespace zoned::core
