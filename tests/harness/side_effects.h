// SideEffects: what rules ask of the system behind their zone's back, by the function that they
// call.
#pragma once

#include <mutex>
#include <string>
#include <vector>

namespace zoned::harness {

class VirtualServer;

/// One function of the system that rules called, and from where.
struct SideEffect {
    std::string what;      ///< "a clock", "a file", "a random number", "a socket", ...
    std::string function;  ///< "clock_gettime"
    std::string callback;  ///< "on_tick"
    std::string of;        ///< of a file: its path

    friend bool operator==(const SideEffect&, const SideEffect&) = default;
};

/// Which of them rules called. A program that is linked with the
/// harness has functions of libc replaced by those that note the call and pass it on; outside of
/// watched rules they cost nothing to speak of. Instructions of the processor (rdtsc, rdrand) and
/// system calls that bypass libc go unseen.
class SideEffects {
  public:
    /// False where a sanitizer has replaced the functions already.
    [[nodiscard]] static bool work();

    /// From now on, the rules of all zones; not those of a script, which can call nothing. This
    /// must outlive the server.
    void watch(VirtualServer& server);

    /// Each once, in the order of their first calls.
    [[nodiscard]] std::vector<SideEffect> found() const;

    /// "on_tick calls fopen ('score.txt'), a file; ..."; empty: they called none.
    [[nodiscard]] std::string text() const;

    void note(SideEffect effect);

  private:
    mutable std::mutex guard_;  // zones run on several threads
    std::vector<SideEffect> found_;
};

}  // namespace zoned::harness
