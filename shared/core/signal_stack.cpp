#include "shared/core/signal_stack.h"

#include <signal.h>

#include <array>
#include <memory>

namespace zoned::core {

namespace {

class SignalStack {
  public:
    SignalStack() {
        stack_t stack{};
        stack.ss_sp = memory_->data();
        stack.ss_size = memory_->size();
        ::sigaltstack(&stack, &former_);
    }

    /// The kernel must not keep memory that goes, and a sanitizer takes down what it put up.
    ~SignalStack() { ::sigaltstack(&former_, nullptr); }

    SignalStack(const SignalStack&) = delete;
    SignalStack& operator=(const SignalStack&) = delete;

  private:
    using Memory = std::array<char, 65536>;

    std::unique_ptr<Memory> memory_ = std::make_unique<Memory>();
    stack_t former_{};
};

}  // namespace

void add_signal_stack() {
    static thread_local const SignalStack stack;
}

}  // namespace zoned::core
