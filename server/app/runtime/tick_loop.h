// TickLoop: the thread that steps the world at a fixed rate; together with the network thread the
// only reader of the clock.
#pragma once

#include "server/app/log/difficulty_log.h"
#include "server/app/runtime/loop_clock.h"
#include "server/app/runtime/tick_schedule.h"
#include "server/app/runtime/visited_world.h"
#include "server/app/storage/held_output.h"
#include "server/app/world/portal_watch.h"
#include "server/app/world/rules_figures.h"
#include "server/app/world/tick_log.h"
#include "server/app/world/world.h"
#include "server/mailbox/bounded_queue.h"
#include "server/mailbox/latest.h"
#include "server/recording/recorder.h"
#include "server/recording/report.h"
#include "shared/core/histogram.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace zoned::app {

/// Seconds of the steady clock.
double steady_seconds();
/// CPU time of the calling thread, ns.
std::uint64_t thread_cpu_ns();

/// A stall is no load, however long it was.
inline constexpr double kMostLoad = 2.0;

/// The output of a tick, before the network sends it.
struct TickResult {
    Tick tick = 0;
    double server_time_s = 0.0;   ///< nominal time of the tick
    double clock_origin_s = 0.0;  ///< steady clock minus this = server time
    double next_due_s = 0.0;      ///< steady clock: when the next tick is due, unless all stops
    double load = 0.0;            ///< time of the turn before, in periods; at most kMostLoad
    std::vector<mailbox::OutboxItem> items;
    StoreTicket store;                    ///< durable events among the items wait for it
    std::vector<TravelWish> wishes = {};  ///< of a server in a cluster
    std::vector<TravelAhead> ahead = {};  ///< likewise
    std::vector<ClientId> departed = {};  ///< clients whose avatars left; in a cluster alone
};

/// Sums over the run, per pass and over all zones.
struct PassTotals {
    std::uint64_t ran = 0;  ///< (tick, zone) pairs in which it ran
    std::uint64_t skipped = 0;
    std::uint64_t ns = 0;
    std::uint64_t count = 0;
    std::uint64_t zones = 0;  ///< that ran it at least once
    std::string skip_reason;  ///< of the last skip; empty when it always ran
};

/// A zone after its last tick.
struct ZoneSample {
    std::uint32_t entities = 0;
    std::uint32_t ghosts = 0;
    std::uint32_t awake_bodies = 0;
    std::uint32_t viewers = 0;
    std::uint64_t step_ns = 0;  ///< sum of its passes
    std::uint64_t state_hash = 0;
};

struct LoopStats {
    Tick ticks = 0;
    double published_s = 0.0;  ///< steady clock, of a published copy
    core::Histogram wall_ms;   ///< from a tick's start to its end
    core::Histogram cpu_ms;    ///< the same in thread CPU time, all threads of the world
    core::Histogram late_ms;   ///< from when a tick was due to its start
    /// The loop's time for a tick and all that goes with it, looks at the world among them: of the
    /// last whole ten seconds.
    core::Histogram turn_ms;
    core::Histogram turn_cpu_ms;  ///< the same in thread CPU time
    std::uint64_t overruns = 0;   ///< ticks that took longer than their period by the wall
    std::map<std::string, std::uint64_t> overrun_causes;
    std::uint64_t dropped_ticks = 0;  ///< left out because the loop was too far behind
    std::uint64_t cpu_ns =
        0;  ///< of the loop and the world's workers, sleeping and waiting excluded
    std::uint64_t inbox_dropped = 0;
    std::array<PassTotals, zone::kPasses> passes;
    std::uint64_t handoffs = 0;
    std::uint64_t client_handoffs = 0;
    std::uint64_t undeliverable = 0;
    std::uint64_t script_errors = 0;
    std::size_t parties = 0;
    std::uint64_t party_orders_refused = 0;
    std::uint64_t limit_exceeded = 0;
    RulesFigures rules;
    std::uint64_t fields_clamped = 0;
    std::uint64_t fields_refused = 0;
    std::uint64_t out_of_world = 0;
    std::uint64_t quarantined = 0;
    std::uint64_t deformations_beyond = 0;  ///< soft bodies and ticks, see zone::StepReport
    std::uint64_t substep_limited = 0;      ///< islands and steps beyond the most substeps
    std::uint64_t far_bodies = 0;           ///< bodies and steps where floats are too coarse
    std::uint64_t held_back = 0;  ///< bodies that would have passed through static geometry
    std::uint64_t slowed = 0;     ///< bodies whose speed or spin was cut to the most there is
    std::uint64_t over_budget = 0;
    std::uint64_t inputs = 0;          ///< commands that were due
    std::uint64_t inputs_missing = 0;  ///< of these: not there in time
    std::uint64_t records_sent = 0;
    std::uint64_t records_resent = 0;
    std::uint64_t records_repeated = 0;  ///< of these: ahead of any loss
    std::uint64_t packets_given_up = 0;
    std::uint64_t packets_found = 0;    ///< given up, and acknowledged after all
    std::uint64_t late_clients = 0;     ///< in the last tick: whose acknowledgements are late
    std::uint64_t widened_clients = 0;  ///< in the last tick: with bounds wider than promised
    std::uint64_t unreached = 0;        ///< in the last tick: with nowhere to send to
    std::uint64_t publications = 0;
    std::uint64_t broadcast_ticks = 0;
    std::uint64_t particles = 0;         ///< simulated, in the last tick
    std::uint64_t bursts_sent = 0;       ///< cosmetic ones that reached a client
    std::uint64_t device_particles = 0;  ///< systems and ticks that a device moved
    std::uint64_t device_faults = 0;     ///< systems that lost their device
    std::uint32_t entities = 0;
    std::uint32_t awake_bodies = 0;
    recording::RecorderFigures recording;
    std::uint64_t state_hash = 0;
    std::vector<ZoneSample> zones;
    std::vector<StoppedZone> stopped;
    std::vector<recording::FlappingFigures> state_flapping;  ///< as old as `traffic`
    wire::TrafficTable traffic;  ///< of state packets; renewed once in a while, and by stop()
};

struct LoopSettings {
    double rate_hz = 30.0;
    unsigned max_catch_up = 3;
    std::size_t mailbox_capacity = 65536;
    double publish_every_s = 0.0;  ///< figures for published(); 0: never
    /// Called on the loop's thread when a zone has stopped; may be empty.
    std::function<void()> on_stopped_zone = {};
    /// The store takes a tick's requests here, on the loop's thread, and must not wait. Empty:
    /// nothing answers.
    std::function<StoreTicket(Tick, std::vector<mailbox::StoreRequest>&&)> to_store = {};
    /// With a recorder only: between two ticks, before the output of the first is delivered.
    std::function<void(std::span<const mailbox::InboxItem>, std::vector<mailbox::OutboxItem>&)>
        after_tick = {};
    const config::Settings* cluster = nullptr;  ///< of a server in a cluster; must outlive the loop
};

class TickLoop final : public VisitedWorld {
  public:
    /// `deliver` is called on the loop's thread once per tick. `recorder` may be null.
    TickLoop(World& world,
             const LoopSettings& settings,
             std::function<void(TickResult)> deliver,
             recording::Recorder* recorder);
    ~TickLoop() override;

    void start();
    /// Returns when the running tick is done. Called by the destructor too.
    void stop();

    /// From any thread; false when the mailbox is full (counted).
    bool post(mailbox::InboxItem item) { return inbox_.push(std::move(item)); }

    bool visit(WorldVisit visit) override { return visits_.push(std::move(visit)); }

    /// For development: the clocks of clients follow with delay.
    void set_time_scale(double scale) override { time_scale_.store(scale); }

    [[nodiscard]] double time_scale() const override { return time_scale_.load(); }

    void step_ticks(unsigned ticks) override { steps_.fetch_add(ticks); }

    /// As old as LoopSettings::publish_every_s.
    [[nodiscard]] std::shared_ptr<const LoopStats> published() const override {
        return published_.get();
    }

    /// Grows with every tick, and while the loop stands still on request; from any thread.
    [[nodiscard]] std::uint64_t turns() const { return turns_.load(std::memory_order_relaxed); }

    /// The newest tick that has taken its inputs; from any thread.
    [[nodiscard]] Tick begun() const { return begun_.load(std::memory_order_relaxed); }

    /// A copy of the sums so far; from any thread.
    [[nodiscard]] LoopStats stats() const;

  private:
    void loop();
    void run_tick(double due_s);
    void step_world(std::vector<mailbox::OutboxItem>& out);
    void watch_travel(TickResult& result);
    void count_tick(double late_s, double wall_s, std::uint64_t cpu_ns);
    void count_turn(double wall_s, std::uint64_t cpu_ns);
    void count_zone(std::size_t index);
    void count_traffic();
    void publish();
    void wait_until(double time_s);
    void stand_still();

    World& world_;
    LoopSettings settings_;
    std::function<void(TickResult)> deliver_;
    recording::Recorder* recorder_;
    TickSchedule schedule_;
    LoopClock clock_;
    std::atomic<double> time_scale_{1.0};
    std::atomic<unsigned> steps_{0};
    std::atomic<std::uint64_t> turns_{0};
    std::atomic<Tick> begun_{0};
    mailbox::BoundedQueue<mailbox::InboxItem> inbox_;
    std::vector<mailbox::InboxItem> items_;
    std::vector<std::uint64_t> hashes_;  // of the zones after the last tick
    std::atomic<bool> stop_{false};
    std::thread thread_;
    std::vector<std::array<bool, zone::kPasses>> zone_ran_;  ///< which zone ever ran which pass
    std::vector<recording::FlappingFigures> flapping_logged_;
    std::unique_ptr<PortalWatch> portals_;  ///< null: the server is in no cluster
    LoggedBands logged_bands_;
    TickLog log_;
    OverloadSteps::Load load_;  // of the last tick
    double turn_load_ = 0.0;    // of the last turn
    core::Histogram turns_ms_;  // of the ten seconds that run
    core::Histogram turns_cpu_ms_;
    mutable std::mutex stats_mutex_;
    LoopStats stats_;
    mailbox::Latest<LoopStats> published_;
    double publish_due_s_ = 0.0;
    VisitQueue visits_;
};

}  // namespace zoned::app
