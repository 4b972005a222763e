// Signal stack: memory for handlers of signals that come when a thread's own stack is full.
#pragma once

namespace zoned::core {

/// Gives the calling thread such a stack (sigaltstack(2)), once; it lives as long as the thread.
/// A handler that asks for SA_ONSTACK then reports an overflow of the thread's own stack too.
void add_signal_stack();

}  // namespace zoned::core
