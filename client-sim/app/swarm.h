// Swarm: N bots from the first join to the verdict, over any transport and on any clock.
#pragma once

#include "client-sim/bot/bot.h"
#include "client-sim/measure/collector.h"
#include "client-sim/measure/run_report.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace zoned::app {

struct SwarmSettings {
    std::size_t bots = 1;
    double seconds = 10.0;  ///< length of the run itself, after the last bot was started
    std::vector<bot::Share> mix = bot::default_mix();
    bot::MakeOwnScript make_own_script;  ///< plays in place of the mix; empty: the mix does
    double ramp_per_s = 100.0;           ///< bots started per second
    std::uint64_t seed = 1;
    motion::ConvergenceMethod convergence = motion::ConvergenceMethod::kProjectiveVelocity;
    view::ViewKind view = view::ViewKind::kExtrapolate;
    view::DisplayedState displayed_state = view::DisplayedState::kPredicted;
    std::vector<std::string> tickets;  ///< serialised; one per bot, or empty
    std::string config_digest;
    std::string world;  ///< of a cluster; empty: the server's
    std::vector<std::string> teams = {"red", "blue"};
    bool audit = true;  ///< compare with the truth; without it the verdict covers the other checks
    double audit_every_s = 1.0;
    bool freeze = true;           ///< freeze the world at the end, where the rights allow it
    double freeze_wait_s = 5.0;   ///< time that views may take to converge
    double frozen_audit_s = 0.5;  ///< time between comparisons then
    double path_spread_s = 0.0;   ///< ConditionerSettings::spread_s() of the link conditioner
    bool meter = false;           ///< counts the bytes of packets by purpose
    int header_bytes = 28;        ///< IP and UDP headers per datagram, for the bandwidth
};

/// Join ramp -> run -> freeze -> goodbye. Everything happens within advance().
class Swarm {
  public:
    using MakeTransport = std::function<std::unique_ptr<link::Transport>(std::size_t index)>;

    enum class RunPhase : std::uint8_t {
        kRamp,
        kSettle,  ///< all bots were started, some have not joined yet
        kRun,
        kFreeze,
        kGoodbye,
        kDone
    };

    Swarm(SwarmSettings settings, const MakeTransport& make_transport);
    ~Swarm();

    /// The first call begins the ramp.
    void advance(double now_s);
    /// Ends the run now, as if its seconds were over; before the run begins it does nothing.
    void end_run(double now_s);
    /// Ends everything at once; the report counts up to here.
    void stop(double now_s);

    [[nodiscard]] bool done() const { return phase_ == RunPhase::kDone; }

    [[nodiscard]] RunPhase phase() const { return phase_; }

    /// All numbers and the verdict. Final once done().
    [[nodiscard]] measure::RunReport report() const;

    /// Numbers for the progress line.
    struct Progress {
        const char* phase = "";
        std::size_t started = 0;
        std::size_t online = 0;
        std::size_t joined = 0;
        std::uint64_t samples = 0;
        std::uint64_t findings = 0;
        double seconds_left = 0.0;
    };

    [[nodiscard]] Progress progress(double now_s) const;

    [[nodiscard]] const measure::Bots& bots() const { return bots_; }

    [[nodiscard]] measure::Collector& collector() { return collector_; }

    /// Reason why no bot ever joined; empty when one did.
    [[nodiscard]] std::string unreachable() const;

  private:
    void ramp(double now_s);
    void enter_run(double now_s);
    void enter_freeze(double now_s);
    void freeze(double now_s);
    void enter_goodbye(double now_s);
    [[nodiscard]] bool all_closed() const;
    /// One bot of each world that has the right to freeze it; false where there is none.
    [[nodiscard]] bool ask_to_freeze(bool on) const;

    SwarmSettings settings_;
    view::WorldCache worlds_;
    measure::Collector collector_;
    std::vector<std::unique_ptr<link::Transport>> transports_;
    measure::Bots bots_;
    RunPhase phase_ = RunPhase::kRamp;
    std::size_t started_ = 0;
    double begun_s_ = -1.0;
    double phase_s_ = 0.0;
    double run_seconds_ = 0.0;
    double next_audit_s_ = 0.0;
    bool freeze_asked_ = false;
    measure::RunReport final_;  // taken before the goodbye, which changes the states
};

}  // namespace zoned::app
