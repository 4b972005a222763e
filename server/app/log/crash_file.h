// Crash file: what a process that dies by a signal leaves behind: stack, tick, zone and pass.
#pragma once

#include <string>

namespace zoned::app {

/// From now on SIGSEGV, SIGBUS, SIGFPE, SIGILL and SIGABRT write `folder`/crash-TIME-PID.txt before
/// the process dies by them as ever. What the handler does is async-signal-safe (POSIX, "Signal
/// Concepts"): the stack is walked by a library that was loaded before, and printed without memory.
/// The recorder's thread, where there is one, has a fifth of a second for the last inputs. Threads
/// with a core::add_signal_stack() report an overflow of their own stack too.
void install_crash_file(const std::string& folder);

/// The newest crash file of the folder; empty: there is none.
[[nodiscard]] std::string newest_crash_file(const std::string& folder);

}  // namespace zoned::app
