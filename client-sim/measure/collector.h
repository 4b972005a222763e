// Collector: gathers the measurements of all bots of a run into its report.
#pragma once

#include "client-sim/audit/auditor.h"
#include "client-sim/bot/bot.h"
#include "client-sim/measure/corrections.h"
#include "client-sim/measure/latency.h"
#include "client-sim/measure/run_report.h"

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace zoned::measure {

using Bots = std::vector<std::unique_ptr<bot::Bot>>;

class Collector final : public bot::Observer {
  public:
    /// `header_bytes`: IP and UDP headers per datagram, counted into the bandwidth. `spread_s` as
    /// in client-sim/audit/bound.h.
    Collector(std::size_t bots, int header_bytes, double spread_s);

    /// Settles audits and events; call at any rate, it works ten times a second.
    void advance(const Bots& bots, double now_s);
    /// Ends the measured part of the run: bandwidths stop here, silence is judged.
    void end_run(const Bots& bots, double now_s);
    /// The report so far; `asked` bots were wanted.
    [[nodiscard]] RunReport report(const Bots& bots, std::size_t asked) const;

    /// The number of online bots with the right to audit, and of those that match a frozen record.
    struct ConvergedBots {
        std::size_t online = 0;
        std::size_t seen = 0;
        std::size_t converged = 0;
    };

    [[nodiscard]] ConvergedBots convergence(const Bots& bots) const;
    void forget_frozen();

    [[nodiscard]] const audit::Tally& tally() const { return tally_; }

    void on_joined(bot::Bot& bot, const wire::JoinedMessage& joined) override;
    void on_set_back(bot::Bot& bot) override;
    void on_event(bot::Bot& bot, const wire::EventMessage& event) override;
    void on_audit(bot::Bot& bot, const wire::AuditRecordMessage& record) override;
    void on_shown(bot::Bot& bot, EntityId entity, Tick publication_tick, Tick from_tick) override;
    void on_changed_course(bot::Bot& bot, Tick tick) override;
    void on_correction(bot::Bot& bot, Tick tick, double distance_m) override;

  private:
    /// Counters of one bot at the beginning of its measured time.
    struct Baseline {
        bool taken = false;
        bool ended = false;
        double at_s = 0.0;
        std::uint64_t in = 0;
        std::uint64_t bytes_in = 0;
        std::uint64_t out = 0;
        std::uint64_t bytes_out = 0;
        std::uint64_t frame_bytes_in = 0;
        std::uint64_t audit_bytes_in = 0;
        std::uint64_t shown = 0;
    };

    struct PerBot {
        audit::Auditor auditor;
        Corrections corrections;
        Baseline baseline;
        bool joined = false;
        bool silent = false;
    };

    /// An event that several clients receive.
    struct EventSpread {
        double first_s = 0.0;
        double last_s = 0.0;
        std::uint64_t bots = 0;
        Tick tick = 0;
        bool world = false;
    };

    /// A change of direction that no client has displayed yet.
    struct CourseChange {
        Tick tick = 0;
        double decided_s = 0.0;
        double decided_server_s = 0.0;  // likewise, by the estimate of the bot that decided
        std::size_t decider = 0;
        bool open = false;
    };

    void sample_clocks(const Bots& bots, double now_s);
    void take_baselines(const Bots& bots, double now_s);
    void close_events(const Bots& bots, double now_s, double open_s);
    void count_bot(const bot::Bot& bot, RunReport& report) const;

    int header_bytes_;
    std::vector<PerBot> per_bot_;
    audit::Tally tally_;
    // Numbers of events and entities are those of a world: clients may be in several.
    std::map<std::pair<std::string, std::uint64_t>, EventSpread> event_spreads_;
    std::map<std::pair<std::string, std::uint32_t>, CourseChange> courses_;
    double next_s_ = 0.0;
    double next_clock_s_ = 0.0;
    bool ended_ = false;
    core::Histogram spread_ms_;
    core::Histogram display_ms_;
    Latency latency_;
    std::uint64_t unseen_ = 0;
    std::uint64_t unheard_ = 0;
    core::Histogram rtt_ms_;
    core::Histogram clock_error_ms_;
    double clock_bound_ms_ = 0.0;
    core::Histogram correction_m_;
    core::Histogram jump_m_;
    core::Histogram lead_ticks_;
    core::Histogram view_delay_ticks_;
    core::Histogram down_;
    core::Histogram up_;
    core::Histogram stream_;
    core::Histogram audit_bytes_;
    double updates_ = 0.0;
    double update_seconds_ = 0.0;
};

}  // namespace zoned::measure
